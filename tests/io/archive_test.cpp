#include "io/archive/archive.h"

#include <functional>

#include "io/archive/archive_writers.h"
#include "io/archive/model_bytes.h"
#include "io/archive/tar_headers.h"
#include "io/archive/zip_directory.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/mesh_files.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;

// Text that packs like a mesh does.
std::string text_of(std::size_t bytes, unsigned seed = 1) {
  std::string text;
  while (text.size() < bytes) {
    seed = seed * 1664525u + 1013904223u;
    text += std::to_string(seed >> 8) + (seed % 5 == 0 ? "\n" : " ");
  }
  text.resize(bytes);
  return text;
}

ArchiveEntry entry(const std::string& name, const std::string& content) {
  ArchiveEntry made;
  made.name = name;
  made.content = content;
  return made;
}

ArchiveEntry typed(const std::string& name, char type, const std::string& link = {}) {
  ArchiveEntry made = entry(name, "");
  made.type = type;
  made.link = link;
  return made;
}

// Every member as `name status: reason`, or its unpacked bytes.
std::vector<std::string> outcome_of(const Archive& archive) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < archive.members().size(); ++i) {
    const ArchiveMember& member = archive.members()[i];
    try {
      lines.push_back(member.name + "=" + archive.unpack(i));
    } catch (const ItemError& error) {
      lines.push_back(member.name + " " + std::string(name_of(error.status())) + ": " + error.what());
    }
  }
  return lines;
}

class Written {
 public:
  Written(const std::string& name, const std::string& bytes) : path_(scratch_ / name) {
    write_file(path_, bytes);
  }
  const fs::path& path() const { return path_; }
  std::vector<std::string> outcome() const { return outcome_of(Archive(path_)); }

 private:
  ScratchFolder scratch_;
  fs::path path_;
};

using Lines = std::vector<std::string>;

std::string read_whole(const ByteSource& source) {
  return source.read(0, static_cast<std::size_t>(source.bytes()));
}

// Members that look_at() reads whole and in pieces.
void check_looks(const Archive& archive) {
  for (std::size_t i = 0; i < archive.members().size(); ++i) {
    const std::string whole = archive.unpack(i);
    archive.look_at(i, [&](const ByteSource& source) {
      REQUIRE(source.bytes() == whole.size());
      CHECK(read_whole(source) == whole);
      for (std::size_t at = 0; at < whole.size(); at += whole.size() / 7 + 1)
        CHECK(source.read(at, 1000) == whole.substr(at, 1000));
      CHECK(source.read(0, 10) == whole.substr(0, 10));
      CHECK(source.read(whole.size(), 10).empty());
      CHECK(source.read(whole.size() + 5, 10).empty());
    });
  }
}

}  // namespace

TEST_CASE("member_path: removes dots and empty parts, and escapes paths that leave the archive") {
  CHECK(member_path("./a//b/./c.off").path == "a/b/c.off");
  CHECK_FALSE(member_path("a..b/..c").leads_out);
  CHECK(member_path("a/../../b.off").path == "a/%2E%2E/%2E%2E/b.off");
  CHECK(member_path("../b.off").leads_out);
  CHECK(member_path("/etc/b.off").path == "%2Fetc/b.off");
  CHECK(member_path("/etc/b.off").leads_out);
  CHECK(member_path("").path.empty());
}

TEST_CASE("archives are recognized by their names") {
  CHECK(archive_kind_of("a/X.ZIP") == ArchiveKind::zip);
  CHECK(archive_kind_of("x.tar") == ArchiveKind::tar);
  CHECK(archive_kind_of("x.Tar.GZ") == ArchiveKind::tar_gzip);
  CHECK(archive_kind_of("x.tgz") == ArchiveKind::tar_gzip);
  CHECK(archive_kind_of("x.Obj.gz") == ArchiveKind::gzip);
  for (const char* name : {"x.gz", "x.h5.gz", ".zip", "zip", "x.off", "x.zip.off", ".gz", ""})
    CHECK_FALSE(archive_kind_of(name));
  CHECK(name_without_packing("in/a.b.tar.gz") == "a.b");
  CHECK(name_without_packing("a.OFF.GZ") == "a.OFF");
}

TEST_CASE("archives: every format yields every member, read whole or in parts") {
  std::vector<ArchiveEntry> entries = {
      entry("a.off", "OFF"), entry("dir/empty.obj", ""),
      entry("dir/" + std::string(90, 'x') + "/" + std::string(80, 'y') + ".ply", "ply"),
      entry("large.stl", text_of(1'200'000))};
  const Lines expected = {"a.off=OFF", "dir/empty.obj=", entries[2].name + "=ply",
                          "large.stl=" + entries[3].content};
  entries[0].deflate = false;
  const std::string tar = tar_bytes(entries);
  const std::size_t half = tar.size() / 2;
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"x.zip", zip_bytes(entries)},
           {"x.zip", zip_bytes(entries, true)},
           {"x.zip", zip_bytes(entries, false, "a comment PK\5\6")},
           {"x.zip", "#!/bin/sh\nself-extracting\n" + zip_bytes(entries)},
           {"x.zip", "#!/bin/sh\n" + zip_bytes(entries, true, "both")},
           {"x.tar", tar},
           {"x.tar", tar_bytes(entries, LongNames::ustar)},
           {"x.tar", tar_bytes(entries, LongNames::pax)},
           {"x.tar.gz", gzip_bytes(tar)},
           {"x.tgz", gzip_bytes(tar, 0)},
           {"x.tgz", gzip_bytes(tar.substr(0, half)) + gzip_bytes(tar.substr(half)) + std::string(100, '\0')},
           {"x.tar", gzip_bytes(tar)},
           {"x.tar.gz", tar}}) {
    const Written archive(name, bytes);
    const Archive opened(archive.path());
    INFO(name << ": " << opened.problem());
    CHECK(opened.problem().empty());
    CHECK(outcome_of(opened) == expected);
    check_looks(opened);
  }
}

TEST_CASE("archives: a large .tar.gz is read from all or only some of its access points") {
  std::vector<ArchiveEntry> entries;
  for (int i = 0; i < 24; ++i)
    entries.push_back(entry("m" + std::to_string(i), text_of(150'000 + 1000u * i, i)));
  const std::string tar = tar_bytes(entries);
  for (const std::string& bytes :
       {gzip_bytes(tar), gzip_bytes(tar.substr(0, 1'700'000)) + gzip_bytes(tar.substr(1'700'000))}) {
    const Written file("x.tar.gz", bytes);
    Archive archive(file.path());
    CHECK(archive.index_bytes() > 4 * 32768);
    for (int round = 0; round < 4; ++round) {
      for (std::size_t i = entries.size(); i > 0; i -= std::min<std::size_t>(i, round == 0 ? 1 : 7))
        CHECK(archive.unpack(i - 1) == entries[i - 1].content);
      const std::uint64_t before = archive.index_bytes();
      archive.thin_index();
      CHECK(archive.index_bytes() <= before / 2);
    }
    CHECK(archive.index_bytes() == 0);
  }
}

TEST_CASE("archives: a .gz file with a mesh has one member") {
  const std::string text = text_of(1'200'000);
  for (const std::string& bytes :
       {gzip_bytes(text), gzip_bytes(text.substr(0, 77)) + gzip_bytes(text.substr(77))}) {
    const Written file("a.off.gz", bytes);
    CHECK(file.outcome() == Lines{"a.off=" + text});
    check_looks(Archive(file.path()));
    CHECK(Archive(file.path()).find("a.off") == 0);
    CHECK_FALSE(Archive(file.path()).find("b.off"));
    CHECK_THROWS_AS(Archive(file.path()).unpack(0, 1'000'000), ItemError);
  }
  CHECK(Written("e.off.gz", gzip_bytes("")).outcome() == Lines{"e.off="});
  const std::string whole = gzip_bytes(text_of(300));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const Lines lines = Written("a.off.gz", whole.substr(0, length)).outcome();
    CHECK_THAT(lines.front(), ContainsSubstring("a.off unreadable: cut"));
  }
  CHECK_THAT(Written("a.off.gz", "OFF\n0 0 0\n").outcome().front(), ContainsSubstring("unreadable: damaged"));
}

TEST_CASE("archives: members that cannot be used are reported") {
  std::vector<ArchiveEntry> zip;
  for (const char* name :
       {"ok", "secret", "lzma", "crc", "long", "short", "link", "../out", "/out", "twice", "twice"})
    zip.push_back(entry(name, text_of(200)));
  zip[1].flags = 1;
  zip[2].method = 14;
  zip[3].stated_crc = 12345;
  zip[4].stated_bytes = 100;
  zip[5].stated_bytes = 300;
  zip[6].mode = 0120777;
  const std::string ok = "ok=" + text_of(200);
  CHECK(Written("x.zip", zip_bytes(zip)).outcome() ==
        Lines{ok, "secret unsupported_format: encrypted: unpack the archive beforehand",
              "lzma unsupported_format: packed by method 14 (LZMA) of zip: only stored and deflated members "
              "are read",
              "crc unreadable: damaged: its checksum differs from that in the archive",
              "long unreadable: damaged: it unpacks to more than the archive states",
              "short unreadable: damaged: it unpacks to less than the archive states",
              "link unreadable: a symbolic link: links in archives are not followed",
              "%2E%2E/out unreadable: its name in the archive leads out of the archive (`..` or a leading /)",
              "%2Fout unreadable: its name in the archive leads out of the archive (`..` or a leading /)",
              "twice unreadable: the archive has 2 members of this name"});
  std::vector<ArchiveEntry> tar = {
      entry("ok", text_of(200)), typed("hard", '1', "./ok"), typed("far", '1', "gone"),
      typed("soft", '2', "ok"),  typed("pipe", '6'),         typed("sparse", 'S'),
      typed("folder/", '5'),     typed("../out", '0'),       entry("./last", "z")};
  CHECK(Written("x.tar", tar_bytes(tar)).outcome() ==
        Lines{ok, "hard=" + text_of(200),
              "far unreadable: a link to a file that the archive does not have before it",
              "soft unreadable: a symbolic link: links in archives are not followed",
              "pipe unreadable: not a regular file",
              "sparse unsupported_format: a sparse file in a tar archive",
              "%2E%2E/out unreadable: its name in the archive leads out of the archive (`..` or a leading /)",
              "last=z"});
}

TEST_CASE("archives: a member whose name is empty is refused under the name of a dot") {
  const Lines refused = {"ok=a", "%2E unreadable: its name in the archive is no name of a file"};
  for (const char* const name : {"", ".", "./."}) {
    const std::vector<ArchiveEntry> entries = {entry("ok", "a"), entry(name, "b")};
    CHECK(Written("x.zip", zip_bytes(entries)).outcome() == refused);
    CHECK(Written("x.tar", tar_bytes(entries)).outcome() == refused);
  }
}

TEST_CASE("archives: DOS names are converted, and a folder named like the archive is stripped") {
  ArchiveEntry dos = entry("chair\\a.off", "x");
  dos.dos = true;
  CHECK(Written("x.zip", zip_bytes({dos})).outcome() == Lines{"chair/a.off=x"});
  const Written once("set.zip", zip_bytes({entry("set/a.off", "x"), entry("__MACOSX/a.off", "y")}));
  CHECK(once.outcome() == Lines{"a.off=x", "__MACOSX/a.off=y"});
  const Archive archive(once.path());
  CHECK(archive.find("a.off") == std::size_t{0});
  CHECK(archive.find("set/a.off") == std::size_t{0});
  CHECK_FALSE(archive.find("b.off"));
  CHECK(Written("set.tar", tar_bytes({entry("set/a.off", "x"), entry("b.off", "y")})).outcome() ==
        Lines{"set/a.off=x", "b.off=y"});
}

TEST_CASE("archives: decompression bombs are refused before memory is allocated") {
  constexpr std::uint64_t size = (std::uint64_t{64} << 20) + 1;
  const std::string zeros(size, '\0');
  const Written zip("x.zip", zip_bytes({entry("bomb.off", zeros), entry("ok.off", "x")}));
  const Lines lines = zip.outcome();
  CHECK_THAT(lines[0], ContainsSubstring("bomb.off unreadable: ") &&
                           ContainsSubstring("bytes unpack to 67108865 or more"));
  CHECK(lines[1] == "ok.off=x");
  CHECK_THAT(Written("x.off.gz", gzip_bytes(zeros, 1)).outcome().front(),
             ContainsSubstring("decompression bomb"));
  const Archive tar(Written("x.tar.gz", gzip_bytes(tar_bytes({entry("a.off", zeros)}), 1)).path());
  CHECK_THAT(tar.problem(), ContainsSubstring("decompression bomb"));
  // Many members of one place.
  std::vector<ArchiveEntry> same = {entry("a.off", text_of(500)), entry("b.off", text_of(500))};
  same[1].stated_offset = 0;
  for (const std::string& line : Written("x.zip", zip_bytes(same)).outcome())
    CHECK_THAT(line, ContainsSubstring("its bytes overlap those of another member"));
  ArchiveEntry beyond = entry("a.off", "x");
  beyond.stated_offset = 5000;
  CHECK_THAT(Written("x.zip", zip_bytes({beyond})).outcome().front(),
             ContainsSubstring("its bytes lie outside the archive"));
}

namespace {

// Some file systems write a file that is overwritten to disk at once.
void write_new(const fs::path& path, const std::string& bytes) {
  fs::remove(path);
  write_file(path, bytes);
}

// What listing and unpacking gives, whatever the bytes are: every member has its content or a status, and
// where members are missing there is a problem.
void check_named(const fs::path& path, const Lines& whole) {
  try {
    const Archive archive(path);
    const Lines lines = outcome_of(archive);
    if (archive.problem().empty()) CHECK(lines.size() >= whole.size());
    for (std::size_t i = 0; i < archive.members().size(); ++i) {
      try {
        archive.look_at(i, [](const ByteSource& source) { source.read(0, 100); });
      } catch (const ItemError&) {
      }
    }
  } catch (const ItemError& error) {
    CHECK(error.status() == Status::unreadable);
    CHECK(std::string(error.what()).size() > 10);
  }
}

}  // namespace

TEST_CASE("archives: cut at every byte, an archive still yields named members and problems") {
  const std::vector<ArchiveEntry> entries = {entry("a.off", text_of(20)), entry("b/c.off", text_of(50, 2))};
  const ScratchFolder scratch;
  for (const auto& [name, bytes] :
       std::vector<std::pair<std::string, std::string>>{{"x.zip", zip_bytes(entries)},
                                                        {"y.zip", zip_bytes(entries, true)},
                                                        {"x.tar", tar_bytes(entries, LongNames::pax)},
                                                        {"x.tar.gz", gzip_bytes(tar_bytes(entries))}}) {
    write_file(scratch / name, bytes);
    const Lines whole = outcome_of(Archive(scratch / name));
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      // Tar archives are cut at every byte below, in memory.
      if (name == "x.tar" && length % 64 != 63) continue;
      write_new(scratch / name, bytes.substr(0, length));
      INFO(name << " cut to " << length << " of " << bytes.size());
      check_named(scratch / name, whole);
    }
  }
}

TEST_CASE("read_tar_headers, read_zip_directory: cut at every byte, no member is lost silently") {
  const std::vector<ArchiveEntry> entries = {entry("a.off", text_of(90)), entry("b/c.off", text_of(700, 2))};
  for (const LongNames names : {LongNames::gnu, LongNames::pax}) {
    const std::string bytes = tar_bytes(entries, names);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      INFO("cut to " << length << " of " << bytes.size());
      const std::string part = bytes.substr(0, length);
      const MemorySource source(part);
      ArchiveListing listing;
      try {
        listing = read_tar_headers(source);
      } catch (const ItemError& error) {
        CHECK(error.status() == Status::unreadable);
        CHECK(length < 512);
        continue;
      }
      // The first of the two blocks of the end mark is enough.
      CHECK(listing.problem.empty() == (length + 512 >= bytes.size()));
      for (const ArchiveMember& member : listing.members)
        CHECK((member.status == Status::ok) == (member.offset + member.bytes <= length));
    }
  }
  const std::string bytes = zip_bytes(entries);
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    const std::string part = bytes.substr(0, length);
    CHECK_THROWS_AS(read_zip_directory(MemorySource(part)), ItemError);
  }
}

TEST_CASE("read_tar_headers: reads forward only, so packed archives are unpacked once") {
  class Forwards final : public ByteSource {
   public:
    explicit Forwards(std::string content) : content_(std::move(content)) {}
    std::uint64_t bytes() const override { return ~std::uint64_t{0}; }
    std::string read(std::uint64_t offset, std::size_t count) const override {
      CHECK(offset >= end_);
      end_ = offset + count;
      return offset < content_.size() ? content_.substr(offset, count) : std::string();
    }

   private:
    std::string content_;
    mutable std::uint64_t end_ = 0;
  };
  const std::vector<ArchiveEntry> entries = {entry(std::string(150, 'n') + "/a.off", text_of(90)),
                                             typed("b/", '5'), entry("b/c.off", ""),
                                             entry("b/d.off", text_of(512))};
  for (const LongNames names : {LongNames::gnu, LongNames::pax, LongNames::ustar})
    CHECK(read_tar_headers(Forwards(tar_bytes(entries, names))).members.size() == 3);
}

TEST_CASE("archives: flipped bits neither crash nor change content under a checksum") {
  const std::vector<ArchiveEntry> entries = {entry("a.off", text_of(20)), entry("b/c.off", text_of(50, 2))};
  const ScratchFolder scratch;
  for (const auto& [name, bytes] :
       std::vector<std::pair<std::string, std::string>>{{"x.zip", zip_bytes(entries)},
                                                        {"y.zip", zip_bytes(entries, true)},
                                                        {"x.tar", tar_bytes(entries, LongNames::pax)},
                                                        {"x.tar.gz", gzip_bytes(tar_bytes(entries))},
                                                        {"x.off.gz", gzip_bytes(entries[1].content)}}) {
    write_file(scratch / name, bytes);
    const Lines whole = outcome_of(Archive(scratch / name));
    for (std::size_t at = 0; at < bytes.size(); ++at) {
      // Padding of tar, where nothing can go wrong, is passed over quickly.
      if (name == "x.tar" && bytes[at] == '\0' && at % 128 != 0) continue;
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ 1 << at % 8);
      write_new(scratch / name, damaged);
      INFO(name << " with a flipped bit at " << at);
      check_named(scratch / name, whole);
      if (!name.ends_with(".zip")) continue;
      try {
        for (const std::string& line : outcome_of(Archive(scratch / name)))
          if (const std::size_t equals = line.find('=');
              equals != std::string::npos && line.size() > equals + 1)
            CHECK(std::any_of(entries.begin(), entries.end(),
                              [&](const ArchiveEntry& e) { return line.substr(equals + 1) == e.content; }));
      } catch (const ItemError&) {
      }
    }
  }
}

TEST_CASE("archives: an archive replaced while in use is not read, and paths name members") {
  const ScratchFolder scratch;
  write_file(scratch / "x.zip", zip_bytes({entry("d/a.off", "one")}));
  const Archive archive(scratch / "x.zip");
  const PackedFile packed = find_packed(scratch / "x.zip/d/a.off");
  REQUIRE(packed);
  CHECK(packed.archive->unpack(packed.member) == "one");
  CHECK_FALSE(find_packed(scratch / "x.zip/d/b.off"));
  CHECK_FALSE(find_packed(scratch / "x.zip"));
  CHECK_FALSE(find_packed(scratch / "none/a.off"));
  write_file(scratch / "x.zip", zip_bytes({entry("d/a.off", "another")}));
  CHECK_THAT(outcome_of(archive).front(), ContainsSubstring("the archive was changed while it was in use"));
}

TEST_CASE("nested archives: every format in every format yields every member, whole or in parts") {
  const std::vector<ArchiveEntry> entries = {entry("in/a.off", text_of(400)),
                                             entry("in/b.off", text_of(3 << 20, 2)), entry("in/d/c.off", "")};
  const std::pair<const char*, std::string> inner[] = {{"in.zip", zip_bytes(entries)},
                                                       {"in.tar", tar_bytes(entries)},
                                                       {"in.tar.gz", gzip_bytes(tar_bytes(entries))}};
  std::vector<ArchiveEntry> members = {entry("first.txt", text_of(100))};
  for (const auto& [name, bytes] : inner) members.push_back(entry(std::string("sets/") + name, bytes));
  std::vector<ArchiveEntry> stored = members;
  for (ArchiveEntry& member : stored) member.deflate = false;
  const std::pair<const char*, std::string> outer[] = {{"x.zip", zip_bytes(members)},
                                                       {"y.zip", zip_bytes(stored)},
                                                       {"x.tar", tar_bytes(members)},
                                                       {"x.tgz", gzip_bytes(tar_bytes(members))}};
  const ScratchFolder scratch;
  const Lines expected = {"a.off=" + text_of(400), "b.off=" + text_of(3 << 20, 2), "d/c.off="};
  for (const auto& [name, bytes] : outer) {
    write_file(scratch / name, bytes);
    const auto archive = std::make_shared<const Archive>(scratch / name);
    for (const auto& [inner_name, inner_bytes] : inner) {
      INFO(name << " " << inner_name);
      const auto member = archive->find(std::string("sets/") + inner_name);
      REQUIRE(member);
      Archive opened(archive, *member);
      CHECK(opened.problem().empty());
      CHECK(opened.outer() == archive);
      CHECK(opened.path() == scratch / name);
      CHECK(opened.shown() == scratch / name / "sets" / inner_name);
      CHECK(outcome_of(opened) == expected);
      check_looks(opened);
      opened.thin_index();
      CHECK(outcome_of(opened) == expected);
      const PackedFile found = find_packed(scratch / name / "sets" / inner_name / "d/c.off");
      REQUIRE(found);
      CHECK(found.facts().name == "d/c.off");
      CHECK_FALSE(find_packed(scratch / name / "sets" / inner_name / "d/none.off"));
    }
  }
}

TEST_CASE("nested archives: one that cannot be opened is refused with its reason") {
  const ScratchFolder scratch;
  const std::string good = zip_bytes({entry("a.off", text_of(3 << 20))});
  std::vector<ArchiveEntry> members(5);
  const char* names[] = {"locked.zip", "crc.zip", "none.zip", "longer.zip", "cut.tar"};
  for (std::size_t i = 0; i < members.size(); ++i) members[i] = entry(names[i], good);
  members[0].flags = 1;
  members[1].stated_crc = 1;
  members[2].content = text_of(5000);
  members[3].stated_bytes = good.size() - 1;
  members[4].content =
      tar_bytes({entry("a.off", text_of(300)), entry("b.off", text_of(9000))}).substr(0, 3000);
  write_file(scratch / "x.zip", zip_bytes(members));
  const auto archive = std::make_shared<const Archive>(scratch / "x.zip");
  const auto reason = [&](std::size_t member) -> std::string {
    try {
      return Archive(archive, member).problem();
    } catch (const ItemError& error) {
      return error.what();
    }
  };
  CHECK_THAT(reason(0), ContainsSubstring("encrypted"));
  CHECK_THAT(reason(1), ContainsSubstring("its checksum differs"));
  CHECK_THAT(reason(2), ContainsSubstring("this is no zip archive"));
  CHECK_THAT(reason(3), ContainsSubstring("does not unpack to the size"));
  CHECK_THAT(reason(4), ContainsSubstring("it ends within a member"));
  CHECK(outcome_of(Archive(archive, 4)).front() == "a.off=" + text_of(300));
  // A directory of its own that is too large is not taken.
  CHECK_THROWS_WITH(read_zip_directory(MemorySource(good), 10), ContainsSubstring("directory has"));
  // The file is looked at again whenever it is read.
  write_file(scratch / "y.zip", zip_bytes({entry("in.zip", good)}));
  const Archive opened(std::make_shared<const Archive>(scratch / "y.zip"), 0);
  write_file(scratch / "y.zip", zip_bytes({entry("in.zip", good), entry("more", "")}));
  CHECK_THAT(outcome_of(opened).front(), ContainsSubstring("the archive was changed while it was in use"));
}

TEST_CASE("nested archives: the ratios of a bomb do not multiply") {
  // Zeros that are packed twice: each time by less than is_bomb allows, together by more.
  const std::string zeros((std::size_t{64} << 20) + 1, '\0');
  std::string inner;
  for (const std::string& part :
       {tar_bytes({entry("a.off", "OFF")}).substr(0, 1024), tar_bytes({entry("b.off", zeros)})})
    inner += gzip_bytes(part, 1);
  inner += std::string(2'000'000, '\0');  // padding
  REQUIRE_FALSE(is_bomb(inner.size(), zeros.size()));
  ArchiveEntry plain = entry("in.tar.gz", inner), stored = plain;
  stored.deflate = false;
  const auto problem_in = [](const std::string& name, const std::string& bytes) {
    const Written file(name, bytes);
    const auto archive = std::make_shared<const Archive>(file.path());
    CHECK(archive->problem().empty());
    const Archive opened(archive, archive->find("in.tar.gz").value());
    CHECK(outcome_of(opened).front() == "a.off=OFF");
    return opened.problem();
  };
  CHECK_THAT(problem_in("x.zip", zip_bytes({plain})), ContainsSubstring("decompression bomb"));
  CHECK(problem_in("x.zip", zip_bytes({stored})).empty());
  CHECK(problem_in("x.tar", tar_bytes({plain})).empty());
  // In a .tar.gz file it has its part of the file, not what others have.
  const ArchiveEntry other = entry("other.txt", text_of(8 << 20));
  CHECK_THAT(problem_in("x.tar.gz", gzip_bytes(tar_bytes({plain}))), ContainsSubstring("decompression bomb"));
  CHECK_THAT(problem_in("x.tar.gz", gzip_bytes(tar_bytes({plain, other}))),
             ContainsSubstring("decompression bomb"));
  CHECK_THAT(problem_in("x.tar.gz", gzip_bytes(tar_bytes({other, plain}))),
             ContainsSubstring("decompression bomb"));
  CHECK(problem_in("x.tar.gz", gzip_bytes(tar_bytes({plain}), 0)).empty());
}

TEST_CASE("archives: a name that very many members share after case folding is not resolved") {
  std::vector<ArchiveEntry> entries;
  for (unsigned k = 0; k < 4097; ++k) {
    std::string name = "abcdefghijklm.png";
    for (unsigned bit = 0; bit < 13; ++bit)
      if ((k >> bit & 1) != 0) name[bit] = static_cast<char>(name[bit] - 'a' + 'A');
    entries.push_back(entry(name, ""));
  }
  const std::string wanted = "ABCDEFGHIJKLM.PNG", last = entries.back().name;
  CHECK(Archive(Written("x.zip", zip_bytes(entries)).path()).find_in_any_case(last) == 4096u);
  CHECK_FALSE(Archive(Written("x.zip", zip_bytes(entries)).path()).find_in_any_case(wanted));
  entries.pop_back();
  CHECK(Archive(Written("x.zip", zip_bytes(entries)).path()).find_in_any_case(wanted) == 4095u);
}

TEST_CASE("archives as outputs: members are read back as written, with the same bytes every time") {
  const std::vector<std::pair<std::string, std::string>> members = {
      {"a.txt", ""},
      {"folder/b.bin", text_of(511)},
      {"c", text_of(512, 2)},
      {std::string(100, 'd'), text_of(70000, 3)}};
  const auto write = [&](auto writer) {
    for (const auto& [name, content] : members)
      writer.add(name, {std::string_view(content).substr(0, content.size() / 3),
                        std::string_view(content).substr(content.size() / 3)});
    writer.finish();
  };
  const ScratchFolder scratch;
  for (const std::string kind : {"tar", "zip"}) {
    std::string bytes, again;
    for (std::string* const to : {&bytes, &again}) {
      const PutBytes put = [to](std::string_view piece) { *to += piece; };
      if (kind == "tar")
        write(TarWriter(put));
      else
        write(StoredZipWriter(put));
    }
    CHECK(bytes == again);
    const fs::path file = scratch / ("made." + kind);
    write_file(file, bytes);
    const Archive archive(file);
    REQUIRE(archive.members().size() == members.size());
    for (const auto& [name, content] : members) {
      const auto at = archive.find(name);
      REQUIRE(at.has_value());
      CHECK((archive.unpack(*at) == content));
    }
    if (kind != "tar") continue;
    std::uint64_t expected = 1024;
    for (const auto& member : members) expected += TarWriter::member_bytes(member.second.size());
    CHECK(bytes.size() == expected);
  }
  TarWriter refusing([](std::string_view) {});
  CHECK_THROWS_AS(refusing.add(std::string(101, 'n'), {}), std::invalid_argument);
  CHECK_THROWS_AS(refusing.add("", {}), std::invalid_argument);
}

TEST_CASE("archives as outputs: a zip archive without ZIP64 ends below 4 GiB") {
  const std::string block(std::size_t{1} << 26, 'x');
  std::uint64_t written = 0;
  StoredZipWriter zip([&](std::string_view piece) { written += piece.size(); });
  const auto add = [&] { zip.add("block" + std::to_string(written), {block}); };
  for (int i = 0; i < 63; ++i) add();
  CHECK_THROWS_AS(add(), std::length_error);
  zip.finish();
  CHECK(written < std::uint64_t{1} << 32);
}
