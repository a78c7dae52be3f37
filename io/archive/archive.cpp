#include "io/archive/archive.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <new>
#include <utility>

#include "io/archive/little_endian.h"
#include "io/archive/tar_headers.h"
#include "io/archive/zip_directory.h"
#include "io/file/input_file.h"
#include "io/file/name_folding.h"
#include "io/mesh/mesh_format.h"
#include "io/word_list.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

// Members up to this size are unpacked whole, even to look at parts of them.
constexpr std::uint64_t small_bytes = std::uint64_t{1} << 20;
constexpr std::uint64_t most_index_bytes = std::uint64_t{32} << 20;  // of the access points of one pass
// Max size of the directory of a zip inside an archive: it is unpacked whole before it can be read.
constexpr std::uint64_t max_inner_directory = std::uint64_t{256} << 20;
constexpr std::ptrdiff_t max_variants = 4096;  // spellings of one name that are tried, as in a folder on disk

constexpr std::array<std::pair<std::string_view, ArchiveKind>, 4> extensions = {
    {{".zip", ArchiveKind::zip},
     {".tar", ArchiveKind::tar},
     {".tar.gz", ArchiveKind::tar_gzip},
     {".tgz", ArchiveKind::tar_gzip}}};
constexpr std::string_view gzip_extension = ".gz";

std::uint64_t most_unpacked(std::uint64_t packed_bytes) {
  return std::max(most_free_bytes, packed_bytes * most_unpacked_ratio);
}

[[noreturn]] void throw_cut() { throw ItemError(Status::unreadable, "cut: the archive ends within it"); }

// A part of a file.
class PartSource final : public ByteSource {
 public:
  PartSource(const ByteSource& file, std::uint64_t begin, std::uint64_t bytes)
      : file_(file), begin_(begin), bytes_(bytes) {}
  std::uint64_t bytes() const override { return bytes_; }
  std::string read(std::uint64_t offset, std::size_t count) const override {
    if (offset >= bytes_) return {};
    return file_.read(begin_ + offset,
                      static_cast<std::size_t>(std::min<std::uint64_t>(count, bytes_ - offset)));
  }

 private:
  const ByteSource& file_;
  std::uint64_t begin_, bytes_;
};

// Keeps the access points few while they are made, and unpacks no more of a bomb (is_bomb) than shows it.
class FirstPass final : public ByteSource {
 public:
  FirstPass(const InflateSource& source, AccessPoints& points, std::uint64_t packed_bytes)
      : source_(source),
        points_(points),
        packed_bytes_(packed_bytes),
        bomb_bytes_(std::max(most_free_bytes + 1, (packed_bytes + 1) * most_unpacked_ratio)) {}
  std::uint64_t bytes() const override { return source_.bytes(); }
  std::string read(std::uint64_t offset, std::size_t count) const override {
    const bool beyond = offset >= bomb_bytes_;
    if (beyond) offset = bomb_bytes_ - 1;
    std::string bytes = source_.read(offset, beyond ? 1 : count);
    if (offset + bytes.size() >= bomb_bytes_)
      throw ItemError(Status::unreadable, bomb_reason(packed_bytes_, offset + bytes.size()));
    while (points_.memory_bytes() > most_index_bytes) points_.thin();
    return bytes;
  }
  // Unpacks the rest, so that it is checked.
  void finish() const { read(bomb_bytes_, 1); }

 private:
  const InflateSource& source_;
  AccessPoints& points_;
  std::uint64_t packed_bytes_, bomb_bytes_;
};

[[noreturn]] void throw_too_large(std::uint64_t most) {
  throw ItemError(Status::too_large,
                  fmt::format("unpacks to more than the {} MiB that there are for it", most >> 20));
}

}  // namespace

std::optional<ArchiveKind> archive_kind_of(const fs::path& path) {
  const std::string name = lower_ascii(path.filename().string());
  for (const auto& [extension, kind] : extensions)
    if (name.size() > extension.size() && name.ends_with(extension)) return kind;
  MeshFormat format;
  if (name.ends_with(gzip_extension) && mesh_format_of(name_without_packing(path), format))
    return ArchiveKind::gzip;
  return std::nullopt;
}

std::string archive_extensions() {
  std::vector<std::string_view> names;
  for (const auto& [extension, kind] : extensions) names.push_back(extension);
  return word_list(names);
}

std::string name_without_packing(const fs::path& path) {
  std::string name = path.filename().string();
  const std::string lower = lower_ascii(name);
  std::size_t longest = lower.ends_with(gzip_extension) ? gzip_extension.size() : 0;
  for (const auto& [extension, kind] : extensions)
    if (lower.size() > extension.size() && lower.ends_with(extension))
      longest = std::max(longest, extension.size());
  name.resize(name.size() - longest);
  return name;
}

Archive::Archive(fs::path path)
    : path_(std::move(path)), kind_(archive_kind_of(path_).value_or(ArchiveKind::zip)) {
  if (kind_ == ArchiveKind::gzip) {  // looked at when it is read, as a file of its own
    ArchiveMember& member = listing_.members.emplace_back();
    member.name = name_without_packing(path_);
    member.deflated = true;
    position_.emplace(member.name, 0);
    return;
  }
  const InputFile file(path_);
  file_bytes_ = file.bytes();
  modified_ = file.modified();
  list(file);
  enter_top_folder(name_without_packing(path_));
  enter_positions();
}

Archive::Archive(std::shared_ptr<const Archive> outer, std::size_t member)
    : path_(outer->path()), outer_(std::move(outer)), member_in_outer_(member) {
  const fs::path name(outer_->readable(member).name);
  kind_ = archive_kind_of(name).value_or(ArchiveKind::zip);
  unpack_once();
  look_at_archive([this](const ByteSource& bytes) { list(bytes); });
  enter_top_folder(name_without_packing(name));
  enter_positions();
}

// Makes the access points of a packed member, and checks that it is whole.
void Archive::unpack_once() {
  const ArchiveMember& facts = outer_->readable(member_in_outer_);
  if (!facts.deflated || facts.bytes <= small_bytes) return;
  outer_->look_at_archive([&](const ByteSource& file) {
    const std::uint64_t begin = zip_data_offset(file, facts);
    InflateSource source(file, {begin, begin + facts.packed_bytes}, Wrapping::raw, facts.bytes);
    source.record(outer_points_);
    const FirstPass pass(source, outer_points_, facts.packed_bytes);
    constexpr std::size_t piece = std::size_t{1} << 18;
    std::uint32_t crc = 0;
    for (std::uint64_t at = 0;;) {
      const std::string bytes = pass.read(at, piece);
      at += bytes.size();
      crc = libdeflate_crc32(crc, bytes.data(), bytes.size());
      if (at > facts.bytes || (bytes.size() < piece && at < facts.bytes))
        throw ItemError(Status::unreadable,
                        "damaged: it does not unpack to the size that the archive states");
      if (bytes.size() < piece) break;
    }
    if (facts.crc32 && crc != *facts.crc32)
      throw ItemError(Status::unreadable, "damaged: its checksum differs from that in the archive");
  });
}

void Archive::enter_positions() {
  refuse_duplicates(listing_.members);
  for (std::size_t i = 0; i < members().size(); ++i) position_.emplace(members()[i].name, i);
}

std::string_view Archive::name_in_outer() const {
  return outer_ ? std::string_view(outer_->members()[member_in_outer_].name) : std::string_view();
}

fs::path Archive::shown() const { return outer_ ? path_ / name_in_outer() : path_; }

void Archive::thin_index() {
  (outer_points_.memory_bytes() > points_.memory_bytes() ? outer_points_ : points_).thin();
}

void Archive::list(const ByteSource& file) {
  if (file.bytes() == 0) throw ItemError(Status::unreadable, "the file is empty");
  if (kind_ == ArchiveKind::zip) {
    listing_ = read_zip_directory(file, outer_ ? max_inner_directory : ~std::uint64_t{0});
    return;
  }
  // Many a .tar.gz file is none, and the other way round.
  kind_ = file.read(0, 2) == "\x1F\x8B" ? ArchiveKind::tar_gzip : ArchiveKind::tar;
  if (kind_ == ArchiveKind::tar_gzip)
    list_tar_gzip(file);
  else
    listing_ = read_tar_headers(file);
}

void Archive::list_tar_gzip(const ByteSource& file) {
  InflateSource source(file, {0, file.bytes()}, Wrapping::gzip, ~std::uint64_t{0});
  source.record(points_);
  // The ratio of an archive in an archive is that of both together.
  const FirstPass pass(source, points_, outer_ ? outer_->packed_bytes_of(member_in_outer_) : file.bytes());
  listing_ = read_tar_headers(pass);
  if (!listing_.problem.empty()) return;
  try {
    pass.finish();
  } catch (const ItemError& error) {
    listing_.problem = error.what();
  }
}

std::uint64_t Archive::packed_bytes_of(std::size_t member) const {
  const ArchiveMember& facts = members()[member];
  if (kind_ != ArchiveKind::tar_gzip) return facts.packed_bytes;
  const std::uint64_t end = facts.offset + facts.bytes;
  const AccessPoint* const before = points_.before(facts.offset);
  std::uint64_t packed_end = file_bytes_;
  for (std::uint64_t reach = std::uint64_t{1} << 60; reach >= points_.spacing(); reach /= 2) {
    const AccessPoint* const behind = points_.before(end + reach);
    if (behind == nullptr || behind->unpacked < end) break;
    packed_end = behind->packed;
  }
  return std::min(facts.packed_bytes, packed_end - (before == nullptr ? 0 : before->packed));
}

void Archive::enter_top_folder(const std::string& own_name) {
  const std::string top = own_name + "/";
  const auto is_hidden = [](const ArchiveMember& m) {
    return m.name.starts_with('.') || m.name.starts_with("__MACOSX/");
  };
  const auto is_inside = [&](const ArchiveMember& m) { return m.name.starts_with(top) || is_hidden(m); };
  std::vector<ArchiveMember>& members = listing_.members;
  if (!std::all_of(members.begin(), members.end(), is_inside)) return;
  top_ = top;
  for (ArchiveMember& member : members)
    if (member.name.starts_with(top)) member.name.erase(0, top.size());
}

std::optional<std::size_t> Archive::find(std::string_view name) const {
  const auto found = position_.find(name);
  if (found != position_.end()) return found->second;
  if (top_.empty() || !name.starts_with(top_)) return std::nullopt;
  const auto below = position_.find(name.substr(top_.size()));
  return below == position_.end() ? std::nullopt : std::optional(below->second);
}

namespace {

std::uint64_t hash_of(std::string_view text) {  // FNV-1a
  std::uint64_t hash = 0xCBF29CE484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3u;
  return hash;
}

// Which of two variants of a path is meant: by the first part in which they differ.
bool is_meant_before(std::string_view a, std::string_view b, std::string_view wanted) {
  const auto take_part = [](std::string_view& path) {
    const std::string_view part = path.substr(0, path.find('/'));
    path.remove_prefix(std::min(part.size() + 1, path.size()));
    return part;
  };
  while (!a.empty() || !b.empty()) {
    const std::string_view of_a = take_part(a), of_b = take_part(b), part = take_part(wanted);
    if (of_a != of_b) return of_a == part || (of_b != part && of_a < of_b);
  }
  return false;
}

}  // namespace

std::optional<std::size_t> Archive::find_in_any_case(std::string_view name) const {
  if (const auto exact = find(name)) return exact;
  std::call_once(folding_, [&] {
    for (std::uint32_t i = 0; i < members().size(); ++i)
      by_folded_name_.emplace_back(hash_of(folded_name(members()[i].name)), i);
    std::sort(by_folded_name_.begin(), by_folded_name_.end());
  });
  if (!top_.empty() && name.starts_with(top_)) name.remove_prefix(top_.size());
  const std::string folded = folded_name(name);
  const std::uint64_t hash = hash_of(folded);
  const auto first = std::lower_bound(by_folded_name_.begin(), by_folded_name_.end(), std::pair(hash, 0u));
  const auto last = std::upper_bound(first, by_folded_name_.end(), std::pair(hash, ~0u));
  if (last - first > max_variants) return std::nullopt;
  std::optional<std::size_t> found;
  for (auto at = first; at != last; ++at) {
    const std::string& other = members()[at->second].name;
    if (folded_name(other) != folded) continue;
    if (!found || is_meant_before(other, members()[*found].name, name)) found = at->second;
  }
  return found;
}

InputFile Archive::open() const {
  InputFile file(path_);
  const std::timespec now = file.modified();
  if (kind_ != ArchiveKind::gzip &&
      (file.bytes() != file_bytes_ || now.tv_sec != modified_.tv_sec || now.tv_nsec != modified_.tv_nsec))
    throw ItemError(Status::unreadable, "the archive was changed while it was in use");
  return file;
}

void Archive::look_at_archive(const Look& look) const {
  if (outer_)
    outer_->look_at(member_in_outer_, look, &outer_points_);
  else
    look(open());
}

const ArchiveMember& Archive::readable(std::size_t member) const {
  const ArchiveMember& facts = members()[member];
  if (facts.status != Status::ok) throw ItemError(facts.status, facts.reason);
  return facts;
}

// A gzip file ends with its unpacked size, modulo 2^32 and of its last part alone: a hint, believed as far as
// meshes are packed.
std::string Archive::gunzip(const ByteSource& file, std::uint64_t most) const {
  constexpr std::uint64_t usual_ratio = 16;
  const InflateSource source(file, {0, file.bytes()}, Wrapping::gzip, 0, most_unpacked(file.bytes()));
  const std::string stated = file.read(file.bytes() - std::min<std::uint64_t>(4, file.bytes()), 4);
  const std::uint64_t hint = stated.size() == 4 ? little_endian(stated, 0, 4) : 0;
  std::string bytes;
  std::size_t done = 0;
  // One byte more, to see that it is the end.
  auto room = static_cast<std::size_t>(std::min({hint, usual_ratio * file.bytes() + small_bytes, most}) + 1);
  for (;;) {
    bytes.resize(room);
    done += source.next(std::span(bytes).subspan(done));
    if (done > most) throw_too_large(most);
    if (done < room) break;
    room += room / 2 + small_bytes;
  }
  bytes.resize(done);
  return bytes;
}

std::string Archive::unpack(std::size_t member, std::uint64_t most) const {
  readable(member);
  std::string bytes;
  look_at_archive([&](const ByteSource& file) { bytes = unpack_from(file, member, most); });
  return bytes;
}

std::string Archive::unpack_from(const ByteSource& file, std::size_t member, std::uint64_t most) const {
  const ArchiveMember& facts = members()[member];
  if (kind_ == ArchiveKind::gzip) return gunzip(file, most);
  if (facts.bytes > most) throw_too_large(most);
  if (kind_ == ArchiveKind::zip) return unpack_zip_member(file, facts);
  std::string bytes;
  if (kind_ == ArchiveKind::tar_gzip) {
    InflateSource source(file, {0, file.bytes()}, Wrapping::gzip, ~std::uint64_t{0});
    source.use(points_);
    bytes = source.read(facts.offset, static_cast<std::size_t>(facts.bytes));
  } else {
    bytes = file.read(facts.offset, static_cast<std::size_t>(facts.bytes));
  }
  if (bytes.size() < facts.bytes) throw_cut();
  return bytes;
}

void Archive::look_at(std::size_t member, const std::function<void(const ByteSource&)>& look) const {
  look_at(member, look, nullptr);
}

void Archive::look_at(std::size_t member, const Look& look, const AccessPoints* points) const {
  const ArchiveMember& facts = readable(member);
  look_at_archive([&](const ByteSource& file) {
    const InflateSource::Part whole{0, file.bytes()};
    if (kind_ == ArchiveKind::gzip) {
      std::string head(small_bytes, '\0');
      const InflateSource source(file, whole, Wrapping::gzip, 0, most_unpacked(file.bytes()));
      const std::size_t there = source.next(head);
      if (there < head.size()) return look(MemorySource(std::string_view(head).substr(0, there)));
      return look(InflateSource(file, whole, Wrapping::gzip, source.count_rest()));
    }
    if (kind_ == ArchiveKind::tar_gzip) {
      InflateSource source(file, whole, Wrapping::gzip, ~std::uint64_t{0});
      source.use(points_);
      return look(PartSource(source, facts.offset, facts.bytes));
    }
    if (facts.deflated && facts.bytes <= small_bytes) {
      const std::string bytes = inflate_zip_member(file, facts);
      return look(MemorySource(bytes));
    }
    const std::uint64_t begin = kind_ == ArchiveKind::zip ? zip_data_offset(file, facts) : facts.offset;
    if (!facts.deflated) return look(PartSource(file, begin, facts.bytes));
    InflateSource source(file, {begin, begin + facts.packed_bytes}, Wrapping::raw, facts.bytes);
    if (points != nullptr) source.use(*points);
    look(source);
  });
}

std::optional<InnerPath> inner_archive_in_path(const Archive& archive, const fs::path& name) {
  for (fs::path above = name.parent_path(); !above.empty() && above != above.parent_path();
       above = above.parent_path()) {
    const auto kind = archive_kind_of(above);
    if (!kind || *kind == ArchiveKind::gzip) continue;
    if (const auto member = archive.find(above.generic_string()))
      return InnerPath{*member, name.lexically_relative(above)};
  }
  return std::nullopt;
}

}  // namespace meander
