#include "io/archive/model_bytes.h"

#include <algorithm>
#include <utility>

#include "io/digest.h"
#include "io/image/color_image.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

std::uint64_t packed_bytes_of(const PackedFile& packed) {
  return packed && packed.facts().deflated ? packed.facts().packed_bytes : 0;
}

bool is_member(const PackedFile& packed) { return packed && packed.archive->kind() != ArchiveKind::gzip; }

// A file that a member of an archive names; none where the archive has no such member.
PackedFile member_beside(const PackedFile& packed, const std::string& path, bool any_case) {
  const std::string name = (fs::path(packed.facts().name).parent_path() / path).generic_string();
  const auto member = any_case ? packed.archive->find_in_any_case(name) : packed.archive->find(name);
  return member ? PackedFile{packed.archive, *member} : PackedFile{};
}

// Of a model that is no member of an archive.
fs::path folder_of_model(const fs::path& path, const PackedFile& packed) {
  const fs::path folder = (packed ? packed.archive->path() : path).parent_path();
  return folder.empty() ? "." : folder;
}

// The file at the end of these names below a folder. Folders are listed only where no exact name leads to it.
// names_left: how many names the lists may still have.
std::optional<fs::path> find_variant(const fs::path& folder, fs::path::const_iterator name,
                                     const fs::path::const_iterator end, std::size_t& names_left) {
  if (name == end) return folder;
  const auto next = std::next(name);
  std::error_code error;
  if (fs::exists(folder / *name, error))
    if (auto found = find_variant(folder / *name, next, end, names_left)) return found;
  const std::string wanted = name->string();
  std::vector<std::string> others;
  std::size_t names = 0;
  for (fs::directory_iterator at(folder, error), last; !error && at != last; at.increment(error)) {
    if (++names > most_searched_names || names_left == 0) return std::nullopt;
    --names_left;
    const std::string other = at->path().filename().string();
    if (other != wanted && same_but_case(other, wanted)) others.push_back(other);
  }
  std::sort(others.begin(), others.end());
  for (const std::string& other : others)
    if (auto found = find_variant(folder / other, next, end, names_left)) return found;
  return std::nullopt;
}

// As Archive::find_in_any_case does. The path as it stands where there is no such file.
fs::path find_in_any_case(const fs::path& folder, const fs::path& path) {
  std::error_code error;
  if (fs::exists(folder / path, error)) return folder / path;
  std::size_t names_left = 16 * most_searched_names;
  return find_variant(folder, path.begin(), path.end(), names_left).value_or(folder / path);
}

void append_digests(std::span<const CompanionFile> files, std::vector<std::uint8_t>& digests) {
  for (const CompanionFile& file : files) {
    std::array<std::uint8_t, 32> digest{};
    if (file.problem.empty()) digest = sha256(file.bytes);
    digests.insert(digests.end(), digest.begin(), digest.end());
  }
}

}  // namespace

std::span<const std::byte> ModelBytes::File::bytes() const {
  return on_disk ? on_disk->bytes() : std::as_bytes(std::span<const char>(unpacked));
}

ModelBytes::File ModelBytes::open(const fs::path& path, const PackedFile& packed, bool of_colors) {
  File file;
  if (!packed) {
    // Images may be many, and are reserved for once they are open.
    file.on_disk.emplace(path, of_colors ? 0 : FileBytes::most_read);
    return file;
  }
  packed_bytes_ += packed_bytes_of(packed);
  file.unpacked = packed.archive->unpack(packed.member, may_unpack_);
  may_unpack_ -= file.unpacked.size();
  return file;
}

ModelBytes::ModelBytes(const fs::path& path, const PackedFile& packed, MeshFormat format,
                       std::uint64_t most_unpacked, bool colors)
    : format_(format), may_unpack_(most_unpacked), own_(open(path, packed)), colors_(colors) {
  const auto open_all = [&](std::vector<std::string> names, bool of_colors, bool is_image) {
    const std::size_t first = companions_.size();
    for (std::string& name : names) companions_.push_back({std::move(name), {}, {}, is_image});
    for (std::size_t k = first; k < companions_.size(); ++k)
      open_companion(path, packed, companions_[k], of_colors);
  };
  open_all(companion_paths(own_.bytes(), format_), false, false);
  const std::size_t of_surface = companions_.size();
  if (colors_) {
    open_all(color_companion_paths(own_.bytes(), format_), true, format_ == MeshFormat::gltf);
    open_all(library_image_paths(own_.bytes(), format_, companions_), true, true);
  }
  color_companions_ = companions_.size() - of_surface;
}

void ModelBytes::open_companion(const fs::path& path, const PackedFile& packed, CompanionFile& companion,
                                bool any_case) {
  try {
    if (is_member(packed)) {
      const PackedFile member = member_beside(packed, companion.path, any_case);
      if (!member) throw ItemError(Status::unreadable, "the archive has no such member");
      beside_.push_back(open({}, member));
    } else {
      const fs::path folder = folder_of_model(path, packed);
      beside_.push_back(
          open(any_case ? find_in_any_case(folder, companion.path) : folder / companion.path, {}, any_case));
    }
    companion.bytes = beside_.back().bytes();
  } catch (const ItemError& error) {
    if (error.status() == Status::too_large) throw;
    companion.problem = error.what();
  }
}

std::span<const CompanionFile> ModelBytes::surface_companions() const {
  return std::span(companions_).first(companions_.size() - color_companions_);
}

std::uint64_t ModelBytes::file_bytes() const {
  std::uint64_t bytes = own_.bytes().size();
  for (const CompanionFile& companion : surface_companions()) bytes += companion.bytes.size();
  return bytes;
}

std::uint64_t ModelBytes::color_bytes() const {
  std::uint64_t bytes = 0, working = 0;
  for (const CompanionFile& companion : std::span(companions_).last(color_companions_)) {
    bytes += companion.bytes.size();
    if (!companion.is_image) continue;
    const ImageMemory memory = memory_of_image(companion.bytes);
    bytes += memory.kept_bytes;
    working = std::max(working, memory.working_bytes);
  }
  return bytes + working;
}

void ModelBytes::fail_if_cut() const {
  if (own_.is_cut() || std::any_of(beside_.begin(), beside_.end(), [](const File& f) { return f.is_cut(); }))
    throw ItemError(Status::unreadable, "the file, or one beside it, was shortened while it was read");
}

std::array<std::uint8_t, 32> ModelBytes::content_sha256() const {
  const std::array<std::uint8_t, 32> own = sha256(own_.bytes());
  fail_if_cut();
  if (surface_companions().empty()) return own;
  std::vector<std::uint8_t> digests(own.begin(), own.end());
  append_digests(surface_companions(), digests);
  fail_if_cut();
  return sha256(std::as_bytes(std::span<const std::uint8_t>(digests)));
}

std::array<std::uint8_t, 32> ModelBytes::color_sha256() const {
  if (color_companions_ == 0) return {};
  std::vector<std::uint8_t> digests;
  append_digests(std::span(companions_).last(color_companions_), digests);
  fail_if_cut();
  return sha256(std::as_bytes(std::span<const std::uint8_t>(digests)));
}

PolygonMesh ModelBytes::mesh(const CancelToken& cancel, const std::function<void(const MeshEstimate&)>& admit,
                             const MeshExtras& extras) const {
  PolygonMesh mesh;
  try {
    mesh = read_mesh(own_.bytes(), format_, cancel, {companions_, admit, colors_, extras});
  } catch (const ItemError&) {
    fail_if_cut();  // what the reader says of zeros is not the reason
    throw;
  }
  fail_if_cut();
  return mesh;
}

MeshEstimate peek_model(const fs::path& path, const PackedFile& packed, MeshFormat format) {
  MeshEstimate estimate;
  if (packed)
    packed.archive->look_at(packed.member,
                            [&](const ByteSource& content) { estimate = peek_mesh(content, format); });
  else
    estimate = peek_mesh(path, format);
  estimate.packed_bytes = packed_bytes_of(packed);
  if (is_member(packed))
    for (const std::string& name : estimate.companions) {
      const PackedFile member = member_beside(packed, name, false);
      if (member) estimate.file_bytes += member.facts().bytes;
      estimate.packed_bytes += packed_bytes_of(member);
    }
  for (const fs::path& file : companion_files(estimate, path, packed)) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (!error) estimate.file_bytes += bytes;
  }
  return estimate;
}

std::vector<fs::path> companion_files(const MeshEstimate& peeked, const fs::path& path,
                                      const PackedFile& packed) {
  std::vector<fs::path> files;
  if (is_member(packed)) return files;
  for (const std::string& name : peeked.companions) files.push_back(folder_of_model(path, packed) / name);
  return files;
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
