#include "io/sealed_file.h"

#include <fmt/format.h>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/run_error.h"

namespace meander {

Seal seal_of(std::string_view bytes) { return sha256(std::as_bytes(std::span(bytes.data(), bytes.size()))); }

void ValueBytes::write_sealed(const std::filesystem::path& path) {
  put(seal());
  replace_file(path, bytes_);
}

SealedBytes::SealedBytes(const std::filesystem::path& path, const SealedKind& kind, std::string_view bytes)
    : path_(path), kind_(kind) {
  if (!bytes.starts_with(kind.magic) || bytes.size() < kind.magic.size() + sizeof(Seal))
    refuse("it does not begin like one");
  const std::string_view content = bytes.substr(0, bytes.size() - sizeof(Seal));
  const Seal seal = seal_of(content);
  if (std::memcmp(seal.data(), bytes.data() + content.size(), seal.size()) != 0)
    refuse("it is damaged: its digest does not match");
  rest_ = content.substr(kind.magic.size());
}

std::string_view SealedBytes::take_bytes(std::size_t each, std::uint64_t count) {
  if (rest_.size() / each < count) refuse("it ends too early");
  const std::string_view taken = rest_.substr(0, each * count);
  rest_.remove_prefix(taken.size());
  return taken;
}

void SealedBytes::end(std::string_view what) const {
  if (!rest_.empty()) refuse(fmt::format("something follows its last {}", what));
}

void SealedBytes::refuse(const std::string& why) const {
  throw RunError(RunError::Kind::unusable,
                 fmt::format("`{}` is not {}: {}{}", path_.string(), kind_.kind, why, kind_.help));
}

}  // namespace meander
