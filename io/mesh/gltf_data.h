// Internal to io/mesh: the values of accessors of a glTF file, wherever their bytes are.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "io/mesh/gltf_document.h"

namespace meander {

class GltfData {
 public:
  // All of it must outlive the object.
  GltfData(const GltfDocument& document, std::optional<std::string_view> binary,
           std::span<const CompanionFile> companions);

  // The elements of an accessor of this width one after another; normalized integers become fractions.
  // Throws ItemError(unreadable) when it is not there or of another width, or leads beyond its bytes.
  std::vector<double> numbers(std::uint32_t accessor, std::uint32_t width, const CancelToken& cancel);
  std::vector<std::uint32_t> indices(std::uint32_t accessor, const CancelToken& cancel);
  // The bytes of a buffer view, unpacked if it is compressed; each view and data URI is unpacked once.
  std::string_view view(std::uint32_t number);
  // Adds Note::buffer_missing for each buffer of a file that is not there.
  void note_missing_buffers(Notes& notes) const;

 private:
  std::string_view buffer(std::uint32_t number);
  std::string_view find_buffer(std::uint32_t number);
  // The bytes of a file, or none with the reason set.
  std::optional<std::string_view> file_of(std::string_view uri, std::string& reason) const;
  std::string_view unpacked(std::uint32_t number, const GltfView& view, std::string_view stream);
  template <class T, class Convert>
  std::vector<T> elements(std::uint32_t number, std::uint32_t width, const CancelToken& cancel,
                          Convert convert);
  // `count` elements of `bytes` each, checked against the view.
  std::string_view part(std::uint32_t view_number, std::uint64_t offset, std::uint64_t count,
                        std::uint64_t bytes, std::uint64_t& stride);

  const GltfDocument& document_;
  std::optional<std::string_view> binary_;
  std::span<const CompanionFile> companions_;
  std::vector<std::optional<std::string_view>> buffers_;     // those that were asked for
  std::vector<std::optional<std::string>> decoded_, views_;  // data URIs and views that were unpacked
};

// The bytes of a data: URI, in base64 or percent-encoded. Throws ItemError(unreadable).
std::string decode_data_uri(std::string_view uri);

}  // namespace meander
