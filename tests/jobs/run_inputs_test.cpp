// Inputs of a run as a user sees them: exit codes, messages, ids, classes, splits.
#include <unistd.h>

#include <filesystem>

#include "io/store/store_reader.h"
#include "io/store/store_verify.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
using Catch::Matchers::ContainsSubstring;

namespace {

using Ids = std::vector<std::string>;

namespace fs = std::filesystem;

ProcessResult run(const std::vector<std::string>& inputs, const fs::path& store,
                  const std::vector<std::string>& more = {}, const ProcessOptions& options = {}) {
  std::vector<std::string> arguments = {"run",      "-o",     store.string(), "-n",  "16",
                                        "--method", "direct", "--progress",   "none"};
  arguments.insert(arguments.end(), inputs.begin(), inputs.end());
  arguments.insert(arguments.end(), more.begin(), more.end());
  return meander_with(arguments, options);
}

void put_mesh(const fs::path& path) {
  fs::create_directories(path.parent_path());
  write_mesh(path, cube());
}

}  // namespace

TEST_CASE("run: an unreadable folder is named and counted, and the run exits with 3") {
  const ScratchFolder scratch;
  put_mesh(scratch / "in/open/a.off");
  put_mesh(scratch / "in/closed/b.off");
  fs::create_directories(scratch / "out");
  for (const char* name : {"", "out"}) fs::permissions(scratch / name, fs::perms::all);
  fs::permissions(scratch / "in/closed", fs::perms::none);
  ProcessOptions options;
  // Root ignores permissions.
  options.in_child = [&] {
    if (::geteuid() == 0 && (::setgid(65534) != 0 || ::setuid(65534) != 0)) ::_exit(77);
    // The temporary folder may lie below one that is closed to that user.
    if (::access(scratch.path().c_str(), X_OK) != 0) ::_exit(77);
  };
  const ProcessResult first = run({scratch / "in"}, scratch / "out/s.h5", {}, options);
  const ProcessResult again = run({scratch / "in"}, scratch / "out/s.h5", {"--json"}, options);
  fs::permissions(scratch / "in/closed", fs::perms::owner_all);
  if (first.exit_code == 77 || first.exit_code == 127) {
    WARN("skipped: cannot become another user, or one that reaches the temporary folder");
    return;
  }
  INFO(first.err);
  CHECK(first.exit_code == 3);
  CHECK_THAT(first.err, ContainsSubstring("/in/closed`: Permission denied"));
  CHECK_THAT(first.out, ContainsSubstring("unread folders               1"));
  CHECK(ids_of(scratch / "out/s.h5") == Ids{"open/a.off"});
  CHECK(again.exit_code == 3);
  CHECK_THAT(again.out, ContainsSubstring("\"unread_folders\":[{\"path\":") &&
                            ContainsSubstring("\"reason\":\"Permission denied\""));
}

TEST_CASE("run: linked class folders are searched, hidden files are counted") {
  const ScratchFolder scratch;
  put_mesh(scratch / "real/a.off");
  put_mesh(scratch / "in/.cache/x.off");
  put_mesh(scratch / "in/__MACOSX/x.off");
  write_file(scratch / "in/._a.off", "x");
  fs::create_directory_symlink("../real", scratch / "in/chair");
  const ProcessResult result = run({scratch / "in"}, scratch / "s.h5", {"--label-from-folder"});
  INFO(result.err);
  CHECK(result.exit_code == 0);
  CHECK(ids_of(scratch / "s.h5") == Ids{"chair/a.off"});
  CHECK(StoreReader(scratch / "s.h5").label_names() == Ids{"chair"});
  CHECK_THAT(result.out, ContainsSubstring("hidden files and folders skipped: 3"));
}

TEST_CASE("run: any file name works, and export and info find items by id and by path") {
  const ScratchFolder scratch;
  for (const char* name : {"caf\xE9.off", "two\nlines.off"}) put_mesh(scratch / "in" / name);
  fs::create_directories(scratch / "bad");
  const std::string store = scratch / "s.h5";
  REQUIRE(run({scratch / "in"}, store).exit_code == 0);
  CHECK(ids_of(store) == Ids{"caf%E9.off", "two%0Alines.off"});
  for (const char* item : {"caf%E9.off", "caf\xE9.off"}) {
    CHECK(meander_with({"info", store, item}).exit_code == 0);
    const fs::path folder = scratch / (std::string(item) + " points");
    CHECK(meander_with({"export", store, item, "-o", folder.string()}).exit_code == 0);
    CHECK(fs::exists(folder / "caf%E9.off.ply"));
  }
  write_file(scratch / "bad/bad\nname.off", "OFF\n");
  const ProcessResult failed = run({scratch / "in", scratch / "bad"}, scratch / "f.h5");
  CHECK(failed.exit_code == 3);
  CHECK_THAT(read_file(scratch / "f.h5.failed.txt"),
             ContainsSubstring("# bad/bad%0Aname.off: ") &&
                 ContainsSubstring("\n# the path of this item contains a line break"));
  // The inputs of the run are found again, by the same ids.
  CHECK(run({scratch / "in"}, store).exit_code == 0);
  CHECK(meander_with({"describe", store, (scratch / "in").string(), "--descriptors", "basics"}).exit_code ==
        0);
}

TEST_CASE("run: lists on two machines make the same store, and a growing list renames nothing") {
  const ScratchFolder scratch;
  ProcessOptions lines, nulls;
  for (const char* machine : {"here", "far/away"})
    for (const char* item : {"chair/a.off", "lamp/b.off"}) put_mesh(scratch / machine / item);
  lines.input =
      (scratch / "here/lamp/b.off").string() + "\n" + (scratch / "here/chair/a.off").string() + "\n";
  nulls.input =
      (scratch / "far/away/chair/a.off").string() + '\0' + (scratch / "far/away/lamp/b.off").string() + '\0';
  REQUIRE(run({"-"}, scratch / "a.h5", {}, lines).exit_code == 0);
  REQUIRE(run({"-", "-0"}, scratch / "b.h5", {}, nulls).exit_code == 0);
  CHECK(read_file(scratch / "a.h5") == read_file(scratch / "b.h5"));
  CHECK(ids_of(scratch / "a.h5") == Ids{"chair/a.off", "lamp/b.off"});

  ProcessOptions one, two;
  one.input = (scratch / "here/chair/a.off").string() + "\n";
  put_mesh(scratch / "here/chair/c.off");
  two.input = one.input + (scratch / "here/chair/c.off").string() + "\n";
  const std::string root = (scratch / "here").string();
  REQUIRE(run({"-", "--root", root}, scratch / "g.h5", {}, one).exit_code == 0);
  CHECK(ids_of(scratch / "g.h5") == Ids{"chair/a.off"});
  // Without --root that of the store applies.
  const ProcessResult grown = run({"-"}, scratch / "g.h5", {}, two);
  INFO(grown.err);
  CHECK(grown.exit_code == 0);
  CHECK(ids_of(scratch / "g.h5") == Ids{"chair/a.off", "chair/c.off"});
  REQUIRE(run({"-", "--root", root}, scratch / "new.h5", {}, two).exit_code == 0);
  CHECK(read_file(scratch / "g.h5") == read_file(scratch / "new.h5"));
  CHECK(meander_with({"describe", scratch / "g.h5", "-", "--descriptors", "basics"}, one).exit_code == 3);

  const ProcessResult outside = run({"-"}, scratch / "g.h5", {}, nulls);
  CHECK(outside.exit_code == 2);
  const ProcessResult needless = run({root}, scratch / "n.h5", {"--null"});
  CHECK(needless.exit_code == 2);
  CHECK_THAT(needless.err, ContainsSubstring("--null applies to lists"));
}

TEST_CASE("run: a layout that items do not have is named with the first of them") {
  const ScratchFolder scratch;
  for (const char* item : {"chair/1.off", "lamp/2.off"}) put_mesh(scratch / "in" / item);
  const std::string of_two =
      "2 of 2 items do not stand as it says, and get no class from it, as `chair/1.off`: "
      "--label-from-folder takes the folder of each file";
  CHECK_THAT(run({scratch / "in", "--layout", "modelnet"}, scratch / "a.h5").out, ContainsSubstring(of_two));
  put_mesh(scratch / "in/lamp/test/3.off");
  CHECK_THAT(run({scratch / "in", "--layout", "modelnet"}, scratch / "b.h5").out,
             ContainsSubstring(
                 "2 of 3 items do not stand as it says, and get no class from it, as `chair/1.off`\n"));
}

TEST_CASE("run, info, export: a labeled tree gives classes and splits, and PointNet files of each split") {
  const ScratchFolder scratch;
  for (const char* item : {"chair/train/1.off", "chair/train/2.off", "chair/test/3.off", "lamp/train/4.off"})
    put_mesh(scratch / "in" / item);
  const std::string store = scratch / "s.h5", folder = (scratch / "pn").string();
  const ProcessResult result = run({scratch / "in"}, store);
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK_THAT(result.out, ContainsSubstring("layout modelnet"));
  const StoreReader reader(store);
  CHECK(reader.label_names() == Ids{"chair", "lamp"});
  CHECK(reader.split(0) == Split::test);
  CHECK(reader.split(1) == Split::train);
  CHECK(reader.label(3) == 1);
  CHECK(verify_store(store).problems.empty());
  CHECK_THAT(meander_with({"info", store}).out,
             ContainsSubstring("split train") && ContainsSubstring("split test"));
  CHECK_THAT(meander_with({"info", store, "chair/test/3.off"}).out,
             ContainsSubstring("split             test"));
  CHECK_THAT(meander_with({"info", store, "0", "--json"}).out, ContainsSubstring("\"split\":\"test\""));

  const auto export_shards = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"export", store, "--pointnet", "-o", folder};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return meander_with(arguments);
  };
  const ProcessResult exported = export_shards({"--shard-rows", "1"});
  REQUIRE(exported.exit_code == 0);
  CHECK_THAT(exported.out, ContainsSubstring("3 rows for training, 1 for tests, 0 for validation"));
  CHECK(fs::exists(folder + "/ply_data_train2.h5"));
  CHECK(fs::exists(folder + "/ply_data_test0.h5"));
  const std::string before = read_file(folder + "/ply_data_train0.h5");
  const ProcessResult refused = export_shards({});
  CHECK(refused.exit_code == 2);
  CHECK_THAT(refused.err, ContainsSubstring("--fresh"));
  CHECK(read_file(folder + "/ply_data_train0.h5") == before);
  CHECK(export_shards({"--fresh"}).exit_code == 0);
  CHECK_FALSE(fs::exists(folder + "/ply_data_train2.h5"));
}

TEST_CASE(
    "run --labels: a file gives classes and splits, and rows without a class stay out of PointNet files") {
  const ScratchFolder scratch;
  for (const char* item : {"1.off", "2.off", "3.off"}) put_mesh(scratch / "in" / item);
  write_file(scratch / "labels.csv", "id,class,split\n1.off,chair,test\n2.off,lamp,\n9.off,lamp,train\n");
  const std::string labels = (scratch / "labels.csv").string(), store = scratch / "s.h5";
  const ProcessResult result = run({scratch / "in"}, store, {"--labels", labels});
  INFO(result.err);
  REQUIRE(result.exit_code == 0);
  CHECK_THAT(result.out, ContainsSubstring("labels: 1 items without a line, 1 lines without an item"));
  const ProcessResult again = run({scratch / "in"}, store, {"--labels", labels, "--json"});
  CHECK_THAT(again.out, ContainsSubstring("\"items_without_label_line\":1,\"label_lines_without_item\":1"));
  const ProcessResult exported =
      meander_with({"export", store, "--pointnet", "-o", (scratch / "pn").string()});
  CHECK(exported.exit_code == 0);
  CHECK_THAT(exported.out, ContainsSubstring("1 rows for training, 1 for tests") &&
                               ContainsSubstring("1 rows without a class were left out"));
  REQUIRE(run({scratch / "in"}, scratch / "none.h5").exit_code == 0);
  const ProcessResult none =
      meander_with({"export", scratch / "none.h5", "--pointnet", "-o", (scratch / "none").string()});
  CHECK(none.exit_code == 2);
  CHECK_THAT(none.err, ContainsSubstring("--labels"));
  CHECK_FALSE(fs::exists(scratch / "none"));
  // The file is an input: nothing writes over it.
  fs::rename(labels, scratch / "x.h5.failed.txt");
  const ProcessResult over =
      run({scratch / "in"}, scratch / "x.h5", {"--labels", (scratch / "x.h5.failed.txt").string()});
  CHECK(over.exit_code == 2);
  write_file(labels, "1.off,chair\n1.off,lamp\n");
  const ProcessResult conflict = run({scratch / "in"}, scratch / "c.h5", {"--labels", labels});
  CHECK(conflict.exit_code == 2);
  CHECK_THAT(conflict.err, ContainsSubstring("line 2"));
  CHECK_FALSE(fs::exists(scratch / "c.h5"));
}

TEST_CASE("run: ShapeNet as distributed, with table and taxonomy, unpacked and as nested zips") {
  const ScratchFolder scratch;
  const fs::path root = scratch / "ShapeNetCore.v2";
  for (const char* item : {"02691156/1a", "03001627/1a", "03001627/2b"})
    put_mesh(root / item / "models/model_normalized.off");
  const std::string table =
      "id,synsetId,subSynsetId,modelId,split\n000001,02691156,02690373,1a,train\n000002,03001627,03001627,1a,"
      "val\n"
      "000003,03001627,03001627,2b,test\n000004,03001627,03001627,9f,test\n";
  const std::string taxonomy = R"([{"synsetId": "02691156", "name": "airplane,plane", "children": []},
                                   {"synsetId": "03001627", "name": "chair", "children": []}])";
  const ProcessResult bare = run({root}, scratch / "bare.h5");
  CHECK(StoreReader(scratch / "bare.h5").label_names() == Ids{"02691156", "03001627"});
  CHECK_THAT(bare.out, !ContainsSubstring("not used"));
  write_file(root / "all.csv", table);
  write_file(root / "taxonomy.json", taxonomy);
  // Rows are labeled as before where nothing is asked for, and the summary says what there is.
  const ProcessResult unused = run({root}, scratch / "unused.h5");
  CHECK(read_file(scratch / "unused.h5") == read_file(scratch / "bare.h5"));
  CHECK_THAT(unused.out, ContainsSubstring("--labels " + (root / "all.csv").string()) &&
                             ContainsSubstring("--labels " + (root / "taxonomy.json").string()));
  const ProcessResult labeled = run({root}, scratch / "s.h5", {"--labels", (root / "all.csv").string()});
  INFO(labeled.out << labeled.err);
  REQUIRE(labeled.exit_code == 0);
  CHECK_THAT(labeled.out,
             ContainsSubstring("labels: 0 items without a line, 1 lines without an item\n    no item: "
                               "`03001627/9f`, `" +
                               (root / "all.csv").string() + "` line 5") &&
                 ContainsSubstring("names of classes: 3 items from `" + (root / "taxonomy.json").string()));
  const StoreReader reader(scratch / "s.h5");
  CHECK(reader.label_names() == Ids{"airplane", "chair"});
  CHECK(reader.split(0) == Split::train);
  CHECK(reader.split(1) == Split::validation);
  CHECK(reader.split(2) == Split::test);
  // The same as a zip of the zips of its synsets, whose table is in it too.
  std::vector<ArchiveEntry> members(4);
  const char* names[] = {"02691156.zip", "03001627.zip", "all.csv", "taxonomy.json"};
  for (std::size_t i = 0; i < members.size(); ++i)
    members[i].name = std::string("ShapeNetCore.v2/") + names[i];
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string synset = std::string(names[i]).substr(0, 8);
    members[i].content = zip_bytes(entries_of(root / synset, synset + "/"));
    members[i].deflate = false;
  }
  members[2].content = table;
  members[3].content = taxonomy;
  fs::create_directories(scratch / "packed");
  const fs::path zip = scratch / "packed/ShapeNetCore.v2.zip";
  write_file(zip, zip_bytes(members));
  const ProcessResult packed = run({zip}, scratch / "zip.h5", {"--labels", (zip / "all.csv").string()});
  INFO(packed.out << packed.err);
  CHECK(packed.exit_code == 0);
  CHECK(read_file(scratch / "zip.h5") == read_file(scratch / "s.h5"));
  // Planned for many tasks it is the same store.
  const ProcessResult planned =
      meander_with({"plan", zip, "-o", scratch / "array.h5", "-n", "16", "--method", "direct", "--shards",
                    "2", "--labels", (zip / "all.csv").string()});
  INFO(planned.out << planned.err);
  REQUIRE(planned.exit_code == 0);
  for (const char* shard : {"0/2", "1/2"})
    CHECK(meander_with({"run", scratch / "array.h5.run", "--shard", shard, "--progress", "none"}).exit_code ==
          0);
  CHECK(meander_with({"merge", scratch / "array.h5.run"}).exit_code == 0);
  CHECK(read_file(scratch / "array.h5") == read_file(scratch / "s.h5"));
}

TEST_CASE("run --labels: several lists of ids are combined, and ambiguous ids are named") {
  const ScratchFolder scratch;
  for (const char* item : {"a/1.off", "b/1.off", "b/2.off", "b/3.off"}) put_mesh(scratch / "in" / item);
  write_file(scratch / "train.txt", "1\n2\n");
  write_file(scratch / "rest.txt", "3\n9\n");
  const Ids both = {"--labels", (scratch / "train.txt").string(), "--labels",
                    "test=" + (scratch / "rest.txt").string()};
  const ProcessResult result = run({scratch / "in"}, scratch / "s.h5", both);
  INFO(result.out << result.err);
  REQUIRE(result.exit_code == 0);
  CHECK_THAT(result.out,
             ContainsSubstring("labels: 2 items without a line, 1 lines without an item\n    no line: "
                               "`a/1.off`\n    no item: `9`, `") &&
                 ContainsSubstring("labels: 1 lines name several items and are ignored") &&
                 ContainsSubstring("several: `1`, `"));
  const StoreReader reader(scratch / "s.h5");
  CHECK(reader.split(0) == Split::none);
  CHECK(reader.split(2) == Split::train);
  CHECK(reader.split(3) == Split::test);
  Ids json = both;
  json.push_back("--json");
  CHECK_THAT(run({scratch / "in"}, scratch / "s.h5", json).out,
             ContainsSubstring("\"ambiguous_label_lines\":1") &&
                 ContainsSubstring("\"item_without_label_line\":\"a/1.off\""));
  // None of the files is written over.
  write_file(scratch / "x.h5.failed.txt", "3\n");
  CHECK(
      run({scratch / "in"}, scratch / "x.h5", {"--labels", "test=" + (scratch / "x.h5.failed.txt").string()})
          .exit_code == 2);
  const ProcessResult unknown =
      run({scratch / "in"}, scratch / "u.h5", {"--labels", (scratch / "rest.txt").string()});
  CHECK(unknown.exit_code == 2);
  CHECK_THAT(unknown.err, ContainsSubstring("--labels train="));
}

TEST_CASE("info: an unfinished run says what it is and how to continue it") {
  const ScratchFolder scratch;
  // The largest model comes first, and others are left.
  const std::string broken = "OFF\n" + std::string(1 << 20, 'x');
  for (const char* name : {"a.off", "c.off", "d.off"}) put_mesh(scratch / "in" / name);
  write_file(scratch / "in/b.off", broken);
  const std::string store = scratch / "s.h5";
  REQUIRE(run({scratch / "in"}, store, {"--max-failures", "0", "-j", "1"}).exit_code == 75);
  const ProcessResult unfinished = meander_with({"info", store});
  CHECK(unfinished.exit_code == 2);
  CHECK_THAT(unfinished.err,
             ContainsSubstring("the store `" + store + "` is not finished: `" + store +
                               ".run` holds an unfinished run over 4 models, begun to sample: the "
                               "command that began it continues it"));
  REQUIRE(run({scratch / "in"}, store).exit_code == 3);
  CHECK(meander_with({"info", store}).err.empty());
  write_file(scratch / "in/e.off", broken);
  for (const char* name : {"f.off", "g.off", "h.off"}) put_mesh(scratch / "in" / name);
  REQUIRE(run({scratch / "in"}, store, {"--max-failures", "0", "-j", "1"}).exit_code == 75);
  const ProcessResult update = meander_with({"info", store});
  CHECK(update.exit_code == 0);
  CHECK_THAT(update.err,
             ContainsSubstring("holds an unfinished run over 8 models, begun to update the store"));
  CHECK_THAT(meander_with({"info", scratch / "none.h5"}).err, ContainsSubstring("does not exist"));
}

TEST_CASE("run: counts with units and exponents give the same store") {
  const ScratchFolder scratch;
  put_mesh(scratch / "in/a.off");
  for (const char* n : {"2000", "2k", "2e3"})
    REQUIRE(meander_with({"run", (scratch / "in").string(), "-o", scratch / (std::string(n) + ".h5"), "-n", n,
                          "--progress", "none", "--memory", "1e9"})
                .exit_code == 0);
  CHECK(read_file(scratch / "2k.h5") == read_file(scratch / "2000.h5"));
  CHECK(read_file(scratch / "2e3.h5") == read_file(scratch / "2000.h5"));
}
