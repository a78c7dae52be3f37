// Archives as inputs of a run, as a user sees them.
#include <algorithm>
#include <filesystem>

#include "io/store/store_reader.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/gltf_files.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

namespace fs = std::filesystem;
using Ids = std::vector<std::string>;

ProcessResult run_models(const Ids& inputs, const fs::path& store, const Ids& more = {},
                         const ProcessOptions& options = {}) {
  Ids arguments = {"run", "-o", store.string(), "-n", "16", "--progress", "none"};
  arguments.insert(arguments.end(), inputs.begin(), inputs.end());
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments, options);
}

// A labeled folder with models of every format, one that is no mesh, and other files.
void put_models(const fs::path& folder) {
  const char* names[] = {"chair/train/a.off", "chair/test/b.obj", "lamp/train/c.ply", "lamp/test/d.stl"};
  int steps = 3;
  for (const char* name : names) {
    fs::create_directories((folder / name).parent_path());
    write_mesh(folder / name, torus(steps, 2 * steps));
    ++steps;
  }
  write_file(folder / "lamp/test/e.off", "OFF\nnothing\n");
  write_file(folder / "readme.txt", "hello");
}

// The same files as a folder, as every kind of archive, and as .gz files one by one, each in a folder of its
// own.
Ids put_all_kinds(const fs::path& scratch) {
  const fs::path folder = scratch / "folder/set";
  put_models(folder);
  const std::vector<ArchiveEntry> entries = entries_of(folder), inside = entries_of(folder, "./set/");
  for (const char* kind : {"zip", "zip64", "tar", "tgz", "inside"}) fs::create_directories(scratch / kind);
  write_file(scratch / "zip/set.zip", zip_bytes(entries));
  write_file(scratch / "zip64/set.ZIP", zip_bytes(inside, true));
  write_file(scratch / "tar/set.tar", tar_bytes(entries));
  write_file(scratch / "tgz/set.tar.gz", gzip_bytes(tar_bytes(inside, LongNames::pax)));
  write_file(scratch / "inside/set.tgz", gzip_bytes(tar_bytes(entries)));
  for (const ArchiveEntry& entry : entries) {
    const fs::path path = scratch / "gz/set" / (entry.name + ".gz");
    fs::create_directories(path.parent_path());
    write_file(path, gzip_bytes(entry.content));
  }
  return {"zip/set.zip", "zip64/set.ZIP", "tar/set.tar", "tgz/set.tar.gz", "inside/set.tgz", "gz/set"};
}

}  // namespace

TEST_CASE("run: folder, zip, tar, tar.gz and gz of the same files give the same bytes") {
  const ScratchFolder scratch;
  const Ids kinds = put_all_kinds(scratch.path());
  const Ids options = {"--label-from-folder", "--describe", "basics"};
  REQUIRE(run_models({scratch / "folder/set"}, scratch / "folder.h5", options).exit_code == 3);
  const std::string expected = read_file(scratch / "folder.h5");
  CHECK(ids_of(scratch / "folder.h5") == Ids{"chair/test/b.obj", "chair/train/a.off", "lamp/test/d.stl",
                                             "lamp/test/e.off", "lamp/train/c.ply"});
  for (const std::string& kind : kinds) {
    const fs::path store = scratch / (fs::path(kind).parent_path().string() + ".h5");
    const ProcessResult result = run_models({scratch / kind}, store, options);
    INFO(kind << result.err << result.out);
    CHECK(result.exit_code == 3);
    CHECK(read_file(store) == expected);
    if (kind != "gz/set") CHECK_THAT(result.out, ContainsSubstring("other files skipped: .txt 1"));
  }
  // In a folder around them, and beside another input.
  REQUIRE(run_models({scratch / "folder"}, scratch / "around.h5").exit_code == 3);
  CHECK(ids_of(scratch / "around.h5").front() == "set/chair/test/b.obj");
  REQUIRE(run_models({scratch / "inside"}, scratch / "around_archive.h5").exit_code == 3);
  CHECK(read_file(scratch / "around_archive.h5") == read_file(scratch / "around.h5"));
  fs::create_directories(scratch / "other");
  write_mesh(scratch / "other/x.off", cube());
  REQUIRE(run_models({scratch / "other", scratch / "folder/set"}, scratch / "two.h5").exit_code == 3);
  REQUIRE(run_models({scratch / "other", scratch / "tar/set.tar"}, scratch / "two_archive.h5").exit_code ==
          3);
  CHECK(read_file(scratch / "two_archive.h5") == read_file(scratch / "two.h5"));
}

TEST_CASE("run: a second run, --reuse and describe find the models of a folder in its archive") {
  const ScratchFolder scratch;
  const Ids kinds = put_all_kinds(scratch.path());
  REQUIRE(run_models({scratch / "folder/set"}, scratch / "s.h5").exit_code == 3);
  const std::string before = read_file(scratch / "s.h5");
  for (const std::string& kind : kinds) {
    const ProcessResult again = run_models({scratch / kind}, scratch / "s.h5", {"--json"});
    INFO(kind << again.err << again.out);
    CHECK(again.exit_code == 3);
    CHECK_THAT(again.out, ContainsSubstring("\"changed\":[]") && ContainsSubstring("\"vanished\":[]"));
    CHECK(read_file(scratch / "s.h5") == before);
    const fs::path described = scratch / ("described" + fs::path(kind).parent_path().string() + ".h5");
    const ProcessResult result = meander_with(
        {"describe", scratch / "s.h5", scratch / kind, "--descriptors", "geodesic", "-o", described});
    INFO(result.err << result.out);
    CHECK(result.exit_code == 0);
  }
  CHECK(read_file(scratch / "describedzip.h5") == read_file(scratch / "describedtgz.h5"));
  const ProcessResult reused =
      run_models({scratch / "zip/set.zip"}, scratch / "r.h5", {"--reuse", scratch / "s.h5"});
  CHECK(reused.exit_code == 3);
  CHECK(read_file(scratch / "r.h5") == before);
  // A member that changes is seen.
  std::vector<ArchiveEntry> entries = entries_of(scratch / "folder/set");
  for (ArchiveEntry& entry : entries)
    if (entry.name == "chair/train/a.off") entry.content += "\n";
  write_file(scratch / "zip/set.zip", zip_bytes(entries));
  const ProcessResult changed = run_models({scratch / "zip/set.zip"}, scratch / "s.h5", {"--json"});
  CHECK_THAT(changed.out, ContainsSubstring("\"changed\":[\"chair/train/a.off\"]"));
}

TEST_CASE("run: an archive in an archive is a folder, one level deep, and deeper ones are named") {
  const ScratchFolder scratch;
  put_all_kinds(scratch.path());
  put_models(scratch / "wide/set/folder/inner");
  REQUIRE(run_models({scratch / "wide/set"}, scratch / "folder.h5").exit_code == 3);
  const std::string expected = read_file(scratch / "folder.h5");
  std::vector<ArchiveEntry> entries = entries_of(scratch / "folder/set");
  const std::pair<const char*, std::string> inner[] = {
      {"folder/inner.zip", zip_bytes(entries)},
      {"folder/inner.tgz", gzip_bytes(tar_bytes(entries_of(scratch / "folder/set", "inner/")))},
      {"./set/folder/inner.tar", tar_bytes(entries)}};
  for (const char* kind : {"a", "b", "c"}) fs::create_directories(scratch / kind);
  const auto entry = [](const std::string& name, const std::string& content) {
    ArchiveEntry made;
    made.name = name;
    made.content = content;
    made.deflate = name.ends_with(".zip");
    return made;
  };
  Ids outer;
  for (const auto& [name, bytes] : inner) {
    outer.push_back((scratch / "a" / ("set" + std::to_string(outer.size()) + ".zip")).string());
    std::string member(name);
    if (member.starts_with("./set/")) member.replace(2, 3, "set2");
    write_file(outer.back(), zip_bytes({entry(member, bytes)}));
  }
  write_file(scratch / "b/set.tar.gz", gzip_bytes(tar_bytes({entry("folder/inner.zip", inner[0].second)})));
  outer.push_back((scratch / "b/set.tar.gz").string());
  for (const std::string& archive : outer) {
    const fs::path store = scratch / (fs::path(archive).filename().string() + ".h5");
    const ProcessResult result = run_models({archive}, store);
    INFO(archive << result.err << result.out);
    CHECK(result.exit_code == 3);  // of the one that is no mesh
    CHECK(read_file(store) == expected);
    CHECK_THAT(read_file(store.string() + ".failed.txt"), ContainsSubstring("/lamp/test/e.off\n"));
    const ProcessResult again = run_models({archive}, scratch / "folder.h5", {"--json"});
    CHECK_THAT(again.out, ContainsSubstring("\"changed\":[]") && ContainsSubstring("\"vanished\":[]"));
    CHECK(read_file(scratch / "folder.h5") == expected);
  }
  // The paths that are named for failed items, and those of any member, can be given.
  CHECK(run_models({"@" + (scratch / "set0.zip.h5.failed.txt").string()}, scratch / "f.h5").exit_code == 3);
  CHECK(ids_of(scratch / "f.h5") == Ids{"e.off"});
  CHECK(run_models({outer[1] + "/folder/inner.tgz/chair/train/a.off"}, scratch / "one.h5").exit_code == 0);
  const ProcessResult alone = run_models({outer[0] + "/folder/inner.zip"}, scratch / "alone.h5");
  CHECK(alone.exit_code == 2);
  CHECK_THAT(alone.err, ContainsSubstring("is an archive in an archive: give `" + outer[0] + "`"));

  // Hidden ones stay closed; an unreadable one, and one a level deeper, are named and change the exit code.
  ArchiveEntry good = entry("x/a.off", mesh_bytes(cube(), MeshFile::off));
  const std::string one = zip_bytes({good});
  write_file(scratch / "c/ok.zip", zip_bytes({entry("__MACOSX/y.zip", one), entry("y.zip", one)}));
  const ProcessResult ok = run_models({scratch / "c"}, scratch / "ok.h5");
  CHECK(ok.exit_code == 0);
  CHECK(ids_of(scratch / "ok.h5") == Ids{"ok/y/x/a.off"});
  CHECK_THAT(ok.out, ContainsSubstring("hidden files and folders skipped: 1"));
  write_file(scratch / "c/ok.zip", zip_bytes({entry("y.zip", zip_bytes({good, entry("deep/z.zip", one)})),
                                              entry("none.tar", "no archive")}));
  const ProcessResult named = run_models({scratch / "c"}, scratch / "named.h5");
  INFO(named.err);
  CHECK(named.exit_code == 3);
  CHECK(ids_of(scratch / "named.h5") == Ids{"ok/y/x/a.off"});
  CHECK_THAT(named.err,
             ContainsSubstring("/c/ok.zip/y.zip/deep/z.zip`: it is in an archive inside an archive") &&
                 ContainsSubstring("/c/ok.zip/none.tar`: this is no tar archive"));
  CHECK_THAT(named.out, ContainsSubstring("unread folders               2"));
  CHECK(run_models({scratch / "c/ok.zip"}, scratch / "as_argument.h5").exit_code == 3);
}

TEST_CASE("run: unreadable members are rows, unreadable archives are named") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  const std::string mesh = mesh_bytes(cube(), MeshFile::off);
  std::vector<ArchiveEntry> entries(6);
  const char* names[] = {"a.off", "locked.off", "twice.off", "twice.off", "../out.off", "crc.off"};
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i].name = names[i];
    entries[i].content = mesh;
  }
  entries[1].flags = 1;
  entries[5].stated_crc = 1;
  write_file(scratch / "in/set.zip", zip_bytes(entries));
  const std::string tar = tar_bytes({entries[0], entries[5]});
  write_file(scratch / "in/cut.tar", tar.substr(0, 1536 + 20));
  write_file(scratch / "in/none.tar.gz", "this is no archive");
  write_file(scratch / "in/cut.off.gz", gzip_bytes(mesh).substr(0, 40));
  const ProcessResult result = run_models({scratch / "in"}, scratch / "s.h5");
  INFO(result.err << result.out);
  CHECK(result.exit_code == 3);
  CHECK_THAT(
      result.err,
      ContainsSubstring("/in/cut.tar`: it ends within a member, at byte 1024 of the archive; its other "
                        "members are not in the store") &&
          ContainsSubstring("/in/none.tar.gz`: this is no tar archive; its contents are not in the store"));
  CHECK_THAT(result.out, ContainsSubstring("unread folders               2"));
  CHECK(ids_of(scratch / "s.h5") == Ids{"cut.off", "cut/a.off", "cut/crc.off", "set/%2E%2E/out.off",
                                        "set/a.off", "set/crc.off", "set/locked.off", "set/twice.off"});
  const std::string failed = read_file(scratch / "s.h5.failed.txt");
  CHECK_THAT(failed,
             ContainsSubstring("# set/locked.off: unsupported_format: encrypted") &&
                 ContainsSubstring("/in/set.zip/locked.off\n") &&
                 ContainsSubstring("# set/twice.off: unreadable: the archive has 2 members of this name") &&
                 ContainsSubstring("# set/crc.off: unreadable: damaged: its checksum differs") &&
                 ContainsSubstring("# cut.off: unreadable: cut") && ContainsSubstring("/in/cut.off.gz\n"));
  CHECK(StoreReader(scratch / "s.h5").report(1).status == Status::ok);
  // Nothing changes for a second run; the failed items can be given back as a list.
  CHECK_THAT(run_models({scratch / "in"}, scratch / "s.h5", {"--json"}).out,
             ContainsSubstring("\"changed\":[]"));
  const ProcessResult list = run_models({"@" + (scratch / "s.h5.failed.txt").string()}, scratch / "f.h5");
  INFO(list.err);
  CHECK(list.exit_code == 3);
  CHECK(ids_of(scratch / "f.h5") == Ids{"cut.off", "cut/crc.off", "set/%2E%2E/out.off", "set/crc.off",
                                        "set/locked.off", "set/twice.off"});
  // As the only input such an archive is an error.
  const ProcessResult alone = run_models({scratch / "in/none.tar.gz"}, scratch / "n.h5");
  CHECK(alone.exit_code == 2);
  CHECK_THAT(alone.err,
             ContainsSubstring("cannot read the archive `") && ContainsSubstring("this is no tar archive"));
}

TEST_CASE("run, measure: members can be named one by one, in lists of archives, and equal ids are refused") {
  const ScratchFolder scratch;
  put_all_kinds(scratch.path());
  const std::string zip = (scratch / "zip/set.zip").string(), tgz = (scratch / "tgz/set.tar.gz").string();
  CHECK(run_models({zip + "/chair/train/a.off"}, scratch / "one.h5").exit_code == 0);
  CHECK(ids_of(scratch / "one.h5") == Ids{"a.off"});
  ProcessOptions list;
  list.input = zip + "/lamp/train/c.ply\n" + tgz + "\n";
  const ProcessResult listed =
      run_models({"-"}, scratch / "list.h5", {"--root", scratch.path().string()}, list);
  INFO(listed.err);
  CHECK(listed.exit_code == 3);
  CHECK(ids_of(scratch / "list.h5").size() == 6);
  CHECK(ids_of(scratch / "list.h5").back() == "zip/set/lamp/train/c.ply");
  const ProcessResult missing = run_models({zip + "/x.off"}, scratch / "m.h5");
  CHECK(missing.exit_code == 2);
  CHECK_THAT(missing.err, ContainsSubstring("has no member `x.off`"));
  write_file(scratch / "folder/set.zip", zip_bytes(entries_of(scratch / "folder/set")));
  const ProcessResult both = run_models({scratch / "folder"}, scratch / "b.h5");
  CHECK(both.exit_code == 2);
  CHECK_THAT(both.err, ContainsSubstring("two items would have the id `set/chair/test/b.obj`") &&
                           ContainsSubstring("/folder/set.zip/chair/test/b.obj`"));
  // The archive is an input: nothing writes over it.
  const ProcessResult over = run_models({zip}, zip);
  CHECK(over.exit_code == 2);
}

TEST_CASE(
    "run: glTF buffers in a folder and in archives give the same bytes, and a changed buffer is detected") {
  const ScratchFolder scratch;
  const fs::path folder = scratch / "folder/set";
  fs::create_directories(folder / "parts/more");
  GltfFile file;
  file.add_points(gltf_cube_points);
  file.add_indices(gltf_cube_indices);
  const std::string scene =
      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"nodes":[{"mesh":0}])";
  write_file(folder / "whole.glb", file.glb(scene));
  write_file(folder / "parts/a.gltf", file.json(scene, "more/cube%20a.bin"));
  write_file(folder / "parts/lost.GLTF", file.json(scene, "lost.bin"));
  write_file(folder / "parts/out.gltf", file.json(scene, "../../cube.bin"));
  write_file(folder.parent_path() / "cube.bin", file.binary);
  write_file(folder / "parts/needs.gltf",
             file.with_data_uri(scene + R"(,"extensionsRequired":["ACME_curves"])"));
  write_file(folder / "parts/more/cube a.bin", file.binary);
  write_file(folder / "cube.bin", file.binary);
  const ProcessResult first = run_models({folder}, scratch / "s.h5");
  INFO(first.err << first.out);
  REQUIRE(first.exit_code == 3);
  REQUIRE(ids_of(scratch / "s.h5") ==
          Ids{"parts/a.gltf", "parts/lost.GLTF", "parts/needs.gltf", "parts/out.gltf", "whole.glb"});
  const auto report = [&](const fs::path& store, std::uint64_t row) {
    return StoreReader(store).report(row);
  };
  CHECK(report(scratch / "s.h5", 0).status == Status::ok);
  CHECK(report(scratch / "s.h5", 0).file_bytes ==
        fs::file_size(folder / "parts/a.gltf") + file.binary.size());
  CHECK_THAT(report(scratch / "s.h5", 1).reason, ContainsSubstring("`lost.bin`"));
  CHECK(report(scratch / "s.h5", 2).status == Status::unsupported_format);
  CHECK_THAT(report(scratch / "s.h5", 2).reason, ContainsSubstring("ACME_curves"));
  CHECK_THAT(report(scratch / "s.h5", 3).reason, ContainsSubstring("leads out of what was given as input"));
  CHECK(report(scratch / "s.h5", 4).status == Status::ok);
  // The same in archives: the same rows but for the sentence of what is missing.
  for (const char* kind : {"zip", "tgz"}) fs::create_directories(scratch / kind);
  write_file(scratch / "zip/set.zip", zip_bytes(entries_of(folder)));
  write_file(scratch / "tgz/set.tar.gz", gzip_bytes(tar_bytes(entries_of(folder, "set/"))));
  for (const char* archive : {"zip/set.zip", "tgz/set.tar.gz"}) {
    INFO(archive);
    const ProcessResult again = run_models({scratch / archive}, scratch / "s.h5", {"--json"});
    CHECK_THAT(again.out, ContainsSubstring("\"changed\":[]") && ContainsSubstring("\"vanished\":[]"));
    CHECK(run_models({scratch / archive}, scratch / "archive.h5", {"--fresh"}).exit_code == 3);
    for (const std::uint64_t row : {0, 2, 3, 4}) {
      CHECK(report(scratch / "archive.h5", row).content_sha256 ==
            report(scratch / "s.h5", row).content_sha256);
      CHECK(report(scratch / "archive.h5", row).points_crc32c == report(scratch / "s.h5", row).points_crc32c);
    }
    CHECK(report(scratch / "archive.h5", 1).status == Status::unreadable);
  }
  // A buffer that changes is a change of its model alone.
  std::string other = file.binary;
  other[14] = '\x00';
  other[15] = '\x40';  // x of the second corner: 2
  write_file(folder / "parts/more/cube a.bin", other);
  CHECK_THAT(run_models({folder}, scratch / "s.h5", {"--json"}).out,
             ContainsSubstring("\"changed\":[\"parts/a.gltf\"]"));
  const ProcessResult retried = run_models({folder}, scratch / "s.h5", {"--retry", "changed", "--json"});
  INFO(retried.err << retried.out);
  CHECK(run_models({folder}, scratch / "f.h5").exit_code == 3);
  CHECK(read_file(scratch / "s.h5") == read_file(scratch / "f.h5"));
  CHECK(run_models({folder}, scratch / "r.h5", {"--reuse", (scratch / "s.h5").string()}).exit_code == 3);
  CHECK(read_file(scratch / "r.h5") == read_file(scratch / "f.h5"));
  // A buffer that appears makes its model readable.
  write_file(folder / "parts/lost.bin", file.binary);
  CHECK_THAT(run_models({folder}, scratch / "s.h5", {"--json"}).out,
             ContainsSubstring("\"changed\":[\"parts/lost.GLTF\"]"));
}

TEST_CASE("run: unpacking stays within --memory") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  // Blanks pack well: much larger unpacked than in the archive.
  {
    ArchiveEntry entry;
    entry.name = "large.off";
    entry.content = mesh_bytes(cube(), MeshFile::off) + std::string(60'000'000, ' ');
    write_file(scratch / "in/a.zip", zip_bytes({entry}));
    write_file(scratch / "in/b.off.gz", gzip_bytes(entry.content));
  }
  write_mesh(scratch / "in/c.off", cube());
  const ProcessResult result =
      run_models({scratch / "in"}, scratch / "s.h5", {"--memory", "80M", "--threads", "2"});
  INFO(result.err << result.out);
  CHECK(result.exit_code == 3);
  const StoreReader store(scratch / "s.h5");
  CHECK(store.report(0).status == Status::too_large);
  CHECK(store.report(1).status == Status::too_large);
  CHECK(store.report(2).status == Status::ok);
  if (!sanitized) CHECK(result.peak_kilobytes <= 80 * 1024);
}
