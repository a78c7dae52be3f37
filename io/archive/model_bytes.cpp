#include "io/archive/model_bytes.h"

#include <algorithm>
#include <utility>

#include "io/digest.h"
#include "io/file/name_folding.h"
#include "io/image/color_image.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

std::uint64_t packed_bytes_of(const PackedFile& packed) {
  return packed && packed.facts().deflated ? packed.facts().packed_bytes : 0;
}

bool is_member(const PackedFile& packed) { return packed && packed.archive->kind() != ArchiveKind::gzip; }

// How many folders a path of a companion leads up, and what follows.
std::pair<std::uint32_t, std::string_view> split_climb(std::string_view path) {
  std::uint32_t climb = 0;
  for (; path.starts_with("../"); path.remove_prefix(3)) ++climb;
  return {climb, path};
}

// The folder of a model that is no member of an archive, or one above it.
fs::path folder_above(const ModelPlace& place, std::uint32_t climb) {
  fs::path folder = (place.packed ? place.packed.archive->path() : place.path).parent_path();
  if (folder.empty()) folder = ".";
  if (climb == 0) return folder;
  folder = fs::absolute(folder).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();  // a slash at its end
  for (; climb > 0; --climb) folder = folder.parent_path();
  return folder;
}

// The name of the archive member that a path beside `place` leads to, or nothing where it leads outside.
std::optional<std::string> member_beside(const ModelPlace& place, std::string_view path) {
  const auto [climb, below] = split_climb(path);
  std::string_view folder = place.packed.facts().name;
  for (std::uint32_t up = 0; up <= climb; ++up) {
    if (up > 0 && folder.empty()) return std::nullopt;
    folder = folder.substr(0, folder.find_last_of('/') == std::string_view::npos ? 0 : folder.rfind('/'));
  }
  return (folder.empty() ? std::string() : std::string(folder) + "/") + std::string(below);
}

// Whether links lead from this file out of that folder.
bool leads_out(const fs::path& file, const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(file, error), root = fs::weakly_canonical(folder, error);
  if (error) return true;
  return std::mismatch(root.begin(), root.end(), whole.begin(), whole.end()).first != root.end();
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
  const std::string wanted = name->string(), folded = folded_name(wanted);
  std::vector<std::string> others;
  std::size_t names = 0;
  for (fs::directory_iterator at(folder, error), last; !error && at != last; at.increment(error)) {
    if (++names > most_searched_names || names_left == 0) return std::nullopt;
    --names_left;
    const std::string other = at->path().filename().string();
    if (other != wanted && folded_name(other) == folded) others.push_back(other);
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

// The file on disk that a path leads to; nothing where it leads out of the input.
std::optional<fs::path> file_beside(const ModelPlace& place, std::string_view path, bool any_case) {
  const auto [climb, below] = split_climb(path);
  if (climb > place.folders_above) return std::nullopt;
  const fs::path folder = folder_above(place, climb);
  const fs::path file = any_case ? find_in_any_case(folder, below) : folder / below;
  // Links that the input itself has above the model are followed, as the model was found by them.
  if (climb > 0 && leads_out(file, folder) && leads_out(file, folder_above(place, place.folders_above)))
    return std::nullopt;
  return file;
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
    file.on_disk.emplace(path, of_colors ? 0 : FileBytes::max_read);
    return file;
  }
  packed_bytes_ += packed_bytes_of(packed);
  file.unpacked = packed.archive->unpack(packed.member, may_unpack_);
  may_unpack_ -= file.unpacked.size();
  return file;
}

ModelBytes::ModelBytes(const ModelPlace& place, std::uint64_t most_unpacked, bool colors)
    : format_(place.format),
      may_unpack_(most_unpacked),
      own_(open(place.path, place.packed)),
      colors_(colors) {
  const auto open_all = [&](std::vector<std::string> names, bool of_colors, bool is_image) {
    const std::size_t first = companions_.size();
    for (std::string& name : names) companions_.push_back({.path = std::move(name), .is_image = is_image});
    for (std::size_t k = first; k < companions_.size(); ++k) open_companion(place, companions_[k], of_colors);
  };
  const FormatRow& row = row_of(format_);
  const std::span<const std::byte> bytes = own_.bytes();
  if (row.companions != nullptr) open_all(row.companions(bytes), false, false);
  const std::size_t of_surface = companions_.size();
  if (colors_ && row.color_companions != nullptr)
    open_all(row.color_companions(bytes), true, row.library_images == nullptr);
  if (colors_ && row.library_images != nullptr) open_all(row.library_images(bytes, companions_), true, true);
  color_companions_ = companions_.size() - of_surface;
}

void ModelBytes::open_companion(const ModelPlace& place, CompanionFile& companion, bool any_case) {
  using Loss = CompanionFile::Loss;
  const auto lose = [&](Loss loss, std::string problem) {
    companion.loss = loss;
    companion.problem = std::move(problem);
  };
  constexpr const char* outside = "leads out of what was given as input";
  try {
    if (is_member(place.packed)) {
      const std::optional<std::string> name = member_beside(place, companion.path);
      if (!name) return lose(Loss::outside, outside);
      const Archive& archive = *place.packed.archive;
      const auto member = any_case ? archive.find_in_any_case(*name) : archive.find(*name);
      if (!member) return lose(Loss::missing, "the archive has no such member");
      beside_.push_back(open({}, {place.packed.archive, *member}));
    } else {
      const std::optional<fs::path> file = file_beside(place, companion.path, any_case);
      if (!file) return lose(Loss::outside, outside);
      std::error_code error;
      const fs::file_type type = fs::status(*file, error).type();
      if (type == fs::file_type::not_found) companion.loss = Loss::missing;
      beside_.push_back(open(*file, {}, any_case));
      companion.loss = Loss::none;
    }
    companion.bytes = beside_.back().bytes();
  } catch (const ItemError& error) {
    if (error.status() == Status::too_large) throw;
    lose(companion.loss == Loss::none ? Loss::unreadable : companion.loss, error.what());
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

MeshEstimate peek_model(const ModelPlace& place) {
  const PackedFile& packed = place.packed;
  MeshEstimate estimate;
  if (packed)
    packed.archive->look_at(packed.member,
                            [&](const ByteSource& content) { estimate = peek_mesh(content, place.format); });
  else
    estimate = peek_mesh(place.path, place.format);
  estimate.packed_bytes = packed_bytes_of(packed);
  if (is_member(packed))
    for (const std::string& path : estimate.companions) {
      const std::optional<std::string> name = member_beside(place, path);
      const auto member = name ? packed.archive->find(*name) : std::nullopt;
      if (!member) continue;
      const PackedFile beside{packed.archive, *member};
      estimate.file_bytes += beside.facts().bytes;
      estimate.packed_bytes += packed_bytes_of(beside);
    }
  for (const fs::path& file : companion_files(estimate, place)) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(file, error);
    if (!error) estimate.file_bytes += bytes;
  }
  return estimate;
}

std::vector<fs::path> companion_files(const MeshEstimate& peeked, const ModelPlace& place) {
  std::vector<fs::path> files;
  if (is_member(place.packed)) return files;
  for (const std::string& name : peeked.companions)
    if (const auto file = file_beside(place, name, false)) files.push_back(*file);
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
  fs::path name = path.lexically_relative(archive);
  if (const auto inner = inner_archive_in_path(*packed.archive, name)) {
    packed.archive = std::make_shared<const Archive>(packed.archive, inner->member);
    name = inner->rest;
  }
  const auto member = packed.archive->find(name.generic_string());
  if (!member) return {};
  packed.member = *member;
  return packed;
}

}  // namespace meander
