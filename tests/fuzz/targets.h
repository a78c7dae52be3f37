// The readers of files from elsewhere, each as a function of arbitrary bytes: what a fuzzer calls, and what
// the tests call with a corpus of their own.
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace meander::fuzz {

// A promise of a reader that was not kept.
class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};
inline void demand(bool kept, const std::string& promise) {
  if (!kept) throw Finding(promise);
}

// One target. run() returns when the reader gave what it promises: a result that holds together, or an error
// of the documented kind with a sentence. Everything else leaves it as an exception: a Finding, or what the
// reader should not have thrown.
struct Target {
  std::string_view name;
  void (*run)(std::string_view bytes);
};

// Ascending by name.
std::span<const Target> targets();

// The targets by source.
void run_off(std::string_view bytes);
void run_obj(std::string_view bytes);
void run_ply(std::string_view bytes);
void run_stl(std::string_view bytes);
void run_gltf(std::string_view bytes);
void run_mtl(std::string_view bytes);
void run_points(std::string_view bytes);
void run_npy(std::string_view bytes);
void run_npz(std::string_view bytes);
void run_tensor(std::string_view bytes);
void run_zip(std::string_view bytes);
void run_tar(std::string_view bytes);
void run_gz(std::string_view bytes);
void run_array(std::string_view bytes);
void run_plan(std::string_view bytes);
void run_journal(std::string_view bytes);
void run_json(std::string_view bytes);
void run_png(std::string_view bytes);
void run_bmp(std::string_view bytes);
void run_gif(std::string_view bytes);
void run_tga(std::string_view bytes);
void run_webp(std::string_view bytes);
void run_labels(std::string_view bytes);

}  // namespace meander::fuzz
