#include "io/archive/model_bytes.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

std::uint64_t packed_bytes_of(const PackedFile& packed) {
  return packed && packed.facts().deflated ? packed.facts().packed_bytes : 0;
}

}  // namespace

ModelBytes::ModelBytes(const fs::path& path, const PackedFile& packed, std::uint64_t most_unpacked)
    : packed_bytes_(packed_bytes_of(packed)) {
  if (packed)
    unpacked_ = packed.archive->unpack(packed.member, most_unpacked);
  else
    mapped_.emplace(path);
}

std::span<const std::byte> ModelBytes::bytes() const {
  return mapped_ ? mapped_->bytes() : std::as_bytes(std::span<const char>(unpacked_));
}

MeshEstimate peek_model(const fs::path& path, const PackedFile& packed, MeshFormat format) {
  if (!packed) return peek_mesh(path, format);
  MeshEstimate estimate;
  packed.archive->look_at(packed.member,
                          [&](const ByteSource& content) { estimate = peek_mesh(content, format); });
  estimate.packed_bytes = packed_bytes_of(packed);
  return estimate;
}

fs::path archive_in_path(const fs::path& path) {
  std::error_code error;
  if (fs::exists(path, error)) return {};
  for (fs::path above = path.parent_path(); !above.empty() && above != above.parent_path();
       above = above.parent_path())
    if (archive_kind_of(above) && fs::is_regular_file(above, error)) return above;
  return {};
}

PackedFile find_packed(const fs::path& path) {
  std::error_code error;
  if (archive_kind_of(path) == ArchiveKind::gzip && fs::exists(path, error))
    return {std::make_shared<const Archive>(path), 0};
  const fs::path archive = archive_in_path(path);
  if (archive.empty()) return {};
  PackedFile packed{std::make_shared<const Archive>(archive), 0};
  const auto member = packed.archive->find(path.lexically_relative(archive).generic_string());
  if (!member) return {};
  packed.member = *member;
  return packed;
}

}  // namespace meander
