// Which files the commands replace and which they keep, and output to a closed pipe or a full device.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "io/file_kind.h"
#include "io/store/run_directory.h"
#include "io/store/store_reader.h"
#include "support/catch.h"
#include "support/meander_program.h"
#include "support/mesh_files.h"
#include "support/sanitized.h"
#include "support/store_rows.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;
namespace fs = std::filesystem;

namespace {

// A folder with a mesh, a store of surfaces with descriptors, points and texts.
struct Place {
  Place() {
    write_file(path("m.off"), mesh_bytes(torus(12, 8), MeshFile::off));
    write_file(path("notes.txt"), "nobody has a copy of this\n");
    write_file(path("points.csv"), "x,y\n0.25,0.25\n0.75,0.25\n0.25,0.75\n0.75,0.75\n");
    REQUIRE(meander_with({"surface", "eight", "torus", "-n", "64", "-o", path("s.h5")}).exit_code == 0);
    REQUIRE(meander_with({"describe", path("s.h5"), "--descriptors", "d2", "--bins", "8"}).exit_code == 0);
  }
  std::string path(std::string_view name) const { return scratch / name; }

  // The command is refused with these words and no byte of the folder has changed.
  void refuses(const std::vector<std::string>& arguments, const std::string& words) const {
    const auto before = content_of(scratch.path());
    const ProcessResult result = meander_with(arguments);
    INFO(Catch::StringMaker<std::vector<std::string>>::convert(arguments) << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, words));
    CHECK((content_of(scratch.path()) == before));
  }
  void does(const std::vector<std::string>& arguments) const {
    const ProcessResult result = meander_with(arguments);
    INFO(Catch::StringMaker<std::vector<std::string>>::convert(arguments) << ": " << result.err);
    CHECK(result.exit_code == 0);
  }

  ScratchFolder scratch;
};

}  // namespace

TEST_CASE("outputs: surface replaces only a store by a store") {
  const Place place;
  place.refuses({"surface", "torus", "-n", "16", "-o", place.path("m.off"), "--fresh"}, "is an OFF mesh");
  place.refuses({"surface", "torus", "-n", "16", "-o", place.path("m.off")}, "is an OFF mesh");
  place.refuses({"surface", "torus", "-n", "16", "-o", place.path("s.h5")}, "--fresh replaces it");
  place.refuses({"surface", place.path("no.nurbs"), "-n", "16", "-o", place.path("s.h5"), "--fresh"},
                "there is no `");
  place.does({"render", "sheet", place.path("s.h5"), "-o", place.path("height.png")});
  fs::create_hard_link(place.path("height.png"), place.path("other.png"));
  place.refuses({"surface", place.path("height.png"), "-n", "16", "-o", place.path("other.png"), "--fresh"},
                "is an input of this command");
  place.does({"surface", "torus", "-n", "16", "-o", place.path("s.h5"), "--fresh"});
  CHECK(StoreReader(place.path("s.h5")).rows() == 1);
}

TEST_CASE("outputs: run never turns an input into a store, and a mistake destroys no store") {
  const Place place;
  fs::create_directory(place.path("v"));
  write_mesh(place.path("v/m.off"), icosphere(1));
  write_mesh(place.path("v/n.off"), icosphere(2));
  fs::create_hard_link(place.path("v/m.off"), place.path("s2.h5"));
  const auto run = [&](const std::string& store, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", place.path("v"), "-o", place.path(store), "-n", "32"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  for (const std::string name : {"v/m.off", "v/../v/m.off", "s2.h5"})
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--fresh"}})
      place.refuses(run(name, more), "is an input of this command");
  place.refuses(run("m.off", {"--fresh"}), "is an OFF mesh: this command replaces only a Meander store");
  place.refuses(run("notes.txt", {"--fresh"}), "is a text file");
  place.does(run("r.h5", {}));
  place.refuses(run("r.h5", {"--fresh", "--reuse", place.path("typo.h5")}), "typo.h5");
  place.refuses(
      run("r.h5", {"--fresh", "--reuse", place.path("r.h5"), "--seed", "2", "--order", "curve"}),
      "made with other parameters: parameter \"order\" was \"progressive\", now it is \"curve\"; parameter "
      "\"seed\" was 1, now it is 2");
  place.refuses(run("r.h5", {"--seed", "2"}), "parameter \"seed\" was 1, now it is 2");
  const std::string before = read_file(place.path("r.h5"));
  place.does(run("r.h5", {"--fresh", "--reuse", place.path("r.h5")}));
  CHECK((read_file(place.path("r.h5")) == before));
}

TEST_CASE("outputs: the old store stays until the new one is complete") {
  const Place place;
  const std::string before = read_file(place.path("s.h5"));
  ProcessOptions full;
  full.in_child = [] {
    const rlimit limit{4096, 4096};
    setrlimit(RLIMIT_FSIZE, &limit);
  };
  const std::vector<std::string> command = {"surface",          "torus",  "-n", "4096", "-o",
                                            place.path("s.h5"), "--fresh"};
  CHECK(meander_with(command, full).exit_code == 75);
  CHECK((read_file(place.path("s.h5")) == before));
  place.does(command);
  CHECK(StoreReader(place.path("s.h5")).samples() == 4096);
}

TEST_CASE("outputs: describe writes over its store or another, never over what it reads") {
  const Place place;
  const std::vector<std::string> describe = {"describe", place.path("s.h5"), "--descriptors",
                                             "a3",       "--bins",           "8"};
  const auto to = [&](const std::string& output, bool fresh) {
    std::vector<std::string> arguments = describe;
    arguments.insert(arguments.end(), {"-o", place.path(output)});
    if (fresh) arguments.emplace_back("--fresh");
    return arguments;
  };
  place.refuses(to("m.off", true), "is an OFF mesh");
  place.refuses(to("notes.txt", true), "is a text file");
  fs::copy_file(place.path("s.h5"), place.path("t.h5"));
  place.refuses(to("t.h5", false), "exists (--fresh replaces it)");
  place.does(to("t.h5", true));
  CHECK(StoreReader(place.path("t.h5")).descriptors().size() == 2);
  CHECK(StoreReader(place.path("s.h5")).descriptors().size() == 1);
  place.does(to("s.h5", false));
  CHECK(StoreReader(place.path("s.h5")).descriptors().size() == 2);
}

TEST_CASE("outputs: pictures replace only pictures") {
  const Place place;
  const std::string store = place.path("s.h5");
  fs::create_hard_link(place.path("m.off"), place.path("mesh.png"));
  place.refuses({"render", "sheet", store, "-o", place.path("m.off")}, "should end in .png");
  place.refuses({"render", "sheet", store, "-o", place.path("mesh.png")}, "is an OFF mesh");
  place.refuses({"render", "sheet", store, "-o", place.path("none/p.png")},
                "does not exist: create it first");
  place.does({"render", "sheet", store, "-o", place.path("p.png")});
  place.does({"render", "sheet", store, "-o", place.path("p.png"), "--item", "torus"});
}

TEST_CASE(
    "outputs: exported point files need --fresh, and one that may not be replaced protects all others") {
  const Place place;
  const std::string store = place.path("s.h5"), out = place.path("out");
  for (const std::string format : {"ply", "off", "xyz"}) {
    place.does({"export", store, "-o", out, "--format", format});
    place.refuses({"export", store, "-o", out, "--format", format}, "exists (--fresh replaces it)");
    place.does({"export", store, "-o", out, "--format", format, "--fresh"});
  }
  // The second file in row order is an existing mesh: the first file is not written either.
  fs::create_directory(place.path("meshes"));
  write_file(place.path("meshes/torus.off"), mesh_bytes(cube(), MeshFile::off));
  place.refuses({"export", store, "-o", place.path("meshes"), "--format", "off", "--fresh"},
                "is an OFF mesh");
  place.refuses({"export", store, "-o", place.path("notes.txt")}, "is not a folder");
  place.refuses({"export", store, "-o", place.path("notes.txt/below")}, "is not a folder");
  // One item named twice is one file.
  place.does({"export", store, "torus", "1", "-o", place.path("one")});
}

TEST_CASE("outputs: a new store has no name of another kind of file") {
  const Place place;
  for (const char* const name : {"new.ply", "new.OBJ", "new.npz", "new.html"})
    place.refuses({"run", place.path("m.off"), "-o", place.path(name)},
                  "has the extension of another kind of file");
  place.does({"run", place.path("m.off"), "-n", "16", "-o", place.path("new.store")});
}

TEST_CASE("outputs: a name with the ending of a format is the file of one item") {
  const Place place;
  const std::string store = place.path("s.h5");
  for (const std::string format : {"ply", "off", "xyz", "npz"}) {
    const std::string file = place.path("one." + format), folder = place.path("as-" + format);
    place.does({"export", store, "torus", "-o", file});
    place.does({"export", store, "torus", "-o", folder, "--format", format});
    CHECK(read_file(file) == read_file(folder + "/torus." + format));
    place.refuses({"export", store, "torus", "-o", file}, "exists (--fresh replaces it)");
    place.does({"export", store, "eight", "-o", file, "--format", format, "--fresh"});
    CHECK(read_file(file) != read_file(folder + "/torus." + format));
    place.refuses({"export", store, "-o", place.path("all." + format)},
                  "is one file, but 2 items of the store have points: name the item behind the store, or "
                  "give a folder");
  }
  place.refuses({"export", store, "0", "1", "-o", place.path("all.ply")}, "but 2 items are named");
  place.refuses({"export", store, "torus", "-o", place.path("c.PLY"), "--format", "npz"},
                "ends in .ply, but --format npz was asked for: give a name in .npz, or a folder");
  place.refuses({"export", store, "-o", place.path("c.npz"), "--format", "webdataset"}, "give a folder");
  place.refuses({"export", store, "torus", "-o", place.path("m.off"), "--fresh"}, "is an OFF mesh");
  place.refuses({"export", store, "-o", place.path("c.csv")}, "name them with --descriptors");
  place.does({"export", store, "-o", place.path("c.csv"), "--descriptors", "d2"});
  CHECK(kind_of_file(place.path("c.csv")) == FileKind::csv);
  // A folder of that name, and one that a slash ends, take all items.
  fs::create_directory(place.path("there.ply"));
  place.does({"export", store, "-o", place.path("there.ply")});
  place.does({"export", store, "-o", place.path("new.ply/")});
  for (const char* folder : {"there.ply/eight.ply", "new.ply/torus.ply"})
    CHECK(kind_of_file(place.path(folder)) == FileKind::ply_points);
}

TEST_CASE("outputs: points exported among meshes are no inputs of the next run, unless they are named") {
  const Place place;
  fs::create_directory(place.path("meshes"));
  write_file(place.path("meshes/a.off"), mesh_bytes(torus(12, 8), MeshFile::off));
  write_file(place.path("meshes/b.ply"), mesh_bytes(cube(), MeshFile::ply_ascii));
  const std::string meshes = place.path("meshes"), store = place.path("r.h5");
  place.does({"run", meshes, "-o", store, "-n", "64"});
  const std::string bytes = read_file(store);
  place.does({"export", store, "a.off", "-o", place.path("meshes/a.ply")});
  place.does({"export", store, "b.ply", "-o", place.path("meshes/b.off"), "--frame", "stored"});
  place.does({"export", store, "-o", place.path("meshes/points")});
  const ProcessResult again = meander_with({"run", meshes, "-o", store, "-n", "64"});
  INFO(again.out << again.err);
  CHECK(again.exit_code == 0);
  CHECK(contains(again.out, "point files of `meander export` skipped: 4"));
  CHECK(read_file(store) == bytes);
  CHECK(
      contains(meander_with({"run", meshes, "-o", store, "-n", "64", "--json"}).out, "\"written_points\":4"));
  const ProcessResult named =
      meander_with({"run", place.path("meshes/a.ply"), "-o", place.path("n.h5"), "-n", "64"});
  CHECK(named.exit_code == 3);
}

TEST_CASE("outputs: a stopped export resumes and keeps its files") {
  const Place place;
  const std::string store = place.path("s.h5"), out = place.path("out");
  const auto short_of_room = [](std::uint64_t bytes) {
    ProcessOptions options;
    options.in_child = [bytes] {
      const rlimit limit{bytes, bytes};
      setrlimit(RLIMIT_FSIZE, &limit);
    };
    return options;
  };
  for (const std::string format : {"ply", "npz", "webdataset"}) {
    INFO(format);
    const std::vector<std::string> command = {"export", store, "-o", out, "--format", format};
    place.does(command);
    const auto whole = content_of(out);
    fs::remove_all(out);
    CHECK(meander_with(command, short_of_room(1000)).exit_code == 75);
    CHECK(fs::exists(out + "/meander-export.json"));
    place.refuses({"export", store, "torus", "-o", out, "--format", format},
                  "another export into `" + out + "` is unfinished: parameter \"items\"");
    if (format != "webdataset") {
      // A file that is there is taken for one that the earlier process made, and is not made again.
      write_file(out + "/eight." + format, whole.begin()->second);
      fs::last_write_time(out + "/eight." + format, fs::file_time_type());
    }
    // What a killed process may leave behind goes.
    write_file(out + (format == "webdataset" ? "/s-000000.tar.tmp77" : "/torus." + format + ".tmp77"),
               "half");
    place.does(command);
    CHECK((content_of(out) == whole));
    if (format != "webdataset")
      CHECK((fs::last_write_time(out + "/eight." + format) == fs::file_time_type()));
    // Begun with --fresh, the files of the export before are not its own.
    std::vector<std::string> fresh = command;
    fresh.emplace_back("--fresh");
    CHECK(meander_with(fresh, short_of_room(1000)).exit_code == 75);
    for (const auto& [name, content] : whole) write_file(name, content.substr(0, 600));  // still of its kind
    place.does(command);
    CHECK((content_of(out) == whole));
    fs::remove_all(out);
  }
}

TEST_CASE("outputs: names too long for a file system are shortened in exports") {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "in");
  const std::string longest = std::string(250, 'a') + ".off", other = std::string(249, 'a') + "b.off";
  write_mesh(scratch / "in" / longest, cube());
  write_mesh(scratch / "in" / other, torus(12, 8));
  // A folder of which nearly all is behind a dot.
  const std::string folder = "1." + std::string(240, 'c');
  fs::create_directories(scratch / "in" / folder);
  write_mesh(scratch / "in" / folder / "x.off", cube());
  REQUIRE(meander_with({"run", scratch / "in", "-o", scratch / "s.h5", "-n", "16"}).exit_code == 0);
  const ProcessResult made = meander_with({"export", scratch / "s.h5", "-o", scratch / "out"});
  INFO(made.err);
  REQUIRE(made.exit_code == 0);
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(scratch / "out")) {
    const std::string name = entry.path().filename().string();
    CHECK(name.size() <= 230);
    if (entry.is_regular_file()) names.insert(name);
  }
  REQUIRE(names.size() == 3);
  for (const std::string& name : names) {
    CHECK((name == "x.off.ply" || name.starts_with(std::string(200, 'a'))));
    CHECK(name.ends_with(".ply"));
  }
}

TEST_CASE("outputs: -o - prints what a file would hold, and nothing else") {
  const Place place;
  const std::string store = place.path("s.h5");
  for (const std::string format : {"ply", "off", "xyz"}) {
    place.does({"export", store, "torus", "-o", place.path("out"), "--format", format});
    const ProcessResult printed = meander_with({"export", store, "torus", "-o", "-", "--format", format});
    CHECK(printed.exit_code == 0);
    CHECK((printed.out == read_file(place.path("out/torus." + format))));
    CHECK(printed.err.empty());
  }
  place.does({"export", store, "--descriptors", "d2", "--format", "csv", "-o", place.path("d.csv")});
  CHECK(meander_with({"export", store, "--descriptors", "d2", "--format", "csv", "-o", "-"}).out ==
        read_file(place.path("d.csv")));
  place.refuses({"export", store, "-o", "-"}, "the points of one item, not of 2");
  place.refuses({"export", store, "--descriptors", "d2", "--format", "npy", "-o", "-"}, "more than one file");
  place.refuses({"export", store, "--pointnet", "-o", "-"}, "-o FOLDER");
  CHECK_FALSE(fs::exists("-"));
}

TEST_CASE("outputs: arrays need --fresh, and shards that are not written again are removed") {
  const Place place;
  const std::string store = place.path("s.h5");
  std::vector<std::string> command = {"export", store, "-o", place.path("np"), "--format", "npz"};
  place.does(command);
  place.refuses(command, "exists (--fresh replaces it)");
  command.emplace_back("--fresh");
  place.does(command);
  write_file(place.path("np/torus.npz"), "my own notes\n");
  place.refuses(command, "is a text file");
  CHECK(
      (meander_with({"export", store, "torus", "-o", "-", "--format", "npz"}).out.substr(0, 4) == "PK\3\4"));

  command = {"export", store, "-o", place.path("wds"), "--format", "webdataset", "--shard-bytes", "1"};
  place.does(command);  // a model a shard
  CHECK(fs::exists(place.path("wds/s-000000.tar")));
  CHECK(fs::exists(place.path("wds/s-000001.tar")));
  place.refuses(command, "exists (--fresh replaces it)");
  command.back() = "1G";
  command.emplace_back("--fresh");
  place.does(command);
  CHECK(fs::exists(place.path("wds/s-000000.tar")));
  CHECK_FALSE(fs::exists(place.path("wds/s-000001.tar")));
  write_file(place.path("wds/s-val-000003.tar"), "my own notes\n");
  place.refuses(command, "is a text file");
  CHECK(fs::exists(place.path("wds/s-000000.tar")));

  place.refuses({"export", store, "-o", "-", "--format", "webdataset"}, "-o FOLDER");
  place.refuses({"export", store, "-o", place.path("x"), "--arrays", "points"}, "npz and webdataset only");
  place.refuses({"export", store, "-o", place.path("x"), "--format", "npz", "--shard-bytes", "2M"},
                "webdataset only");
  place.refuses({"export", store, "-o", place.path("x"), "--format", "npz", "--arrays", "pionts"},
                "did you mean `points`?");
  place.refuses({"export", store, "-o", place.path("x"), "--format", "npz", "--arrays", "points,rgb"},
                "without --colors");
  CHECK_FALSE(fs::exists(place.path("x")));
}

TEST_CASE("outputs: descriptors and PointNet files need --fresh") {
  const Place place;
  const std::string store = place.path("s.h5");
  for (const std::string format : {"csv", "fbin", "npy", "ann-hdf5"}) {
    std::vector<std::string> command = {"export", store, "--descriptors",          "d2", "--format",
                                        format,   "-o",  place.path("d." + format)};
    place.does(command);
    place.refuses(command, "exists (--fresh replaces it)");
    command.emplace_back("--fresh");
    place.does(command);
    command[7] = place.path("notes.txt");
    place.refuses(command, "is a text file");
    command[7] = store;
    place.refuses(command, "is the store itself");
    if (format == "csv") continue;
    write_file(place.path("new.ids.csv"), "my own list\n");
    command[7] = place.path("new");
    place.refuses(command, "new.ids.csv` is a text file");
    fs::remove(place.path("new.ids.csv"));
  }
  std::vector<std::string> command = {"export", store, "--pointnet", "-o", place.path("pn")};
  REQUIRE(
      meander_with({"run", place.path("m.off"), "-o", place.path("r.h5"), "-n", "32", "--label-from-folder"})
          .exit_code == 0);
  command[1] = place.path("r.h5");
  place.does(command);
  place.refuses(command, "exists (--fresh replaces it)");
  command.emplace_back("--fresh");
  place.does(command);
  fs::copy_file(store, place.path("pn/ply_data_train0.h5"), fs::copy_options::overwrite_existing);
  place.refuses(command, "is a Meander store");
}

TEST_CASE("outputs: tables and drawings of retrieve replace only their own kind") {
  const ScratchFolder scratch;
  for (const char* id : {"a/1.off", "a/2.off", "b/3.off", "b/4.off"}) {
    fs::create_directories((scratch / id).parent_path());
    write_mesh(scratch / id, icosphere(1, 1.0 + 0.1 * id[2]));
  }
  fs::create_directory(scratch / "in");
  fs::rename(scratch / "a", scratch / "in/a");
  fs::rename(scratch / "b", scratch / "in/b");
  const auto path = [&](const std::string& name) -> std::string { return scratch / name; };
  REQUIRE(meander_with({"run", path("in"), "-o", path("s.h5"), "-n", "64", "--label-from-folder",
                        "--describe", "d2,a3", "--bins", "8"})
              .exit_code == 0);
  const std::vector<std::pair<std::string, std::string>> outputs = {
      {"--csv", "t.csv"}, {"--matrix", "m.bin"}, {"--picture", "p.svg"}, {"--confusion", "c.png"}};
  std::vector<std::string> all = {"retrieve", "evaluate", path("s.h5")};
  for (const auto& [option, name] : outputs) all.insert(all.end(), {option, path(name)});
  CHECK(meander_with(all).exit_code == 0);
  CHECK(meander_with(all).exit_code == 0);  // each replaces its own kind
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& words) {
    const auto before = content_of(scratch.path());
    const ProcessResult result = meander_with(arguments);
    INFO(result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, words));
    CHECK((content_of(scratch.path()) == before));
  };
  refused({"retrieve", "evaluate", path("s.h5"), "--csv", path("new.csv"), "--matrix", path("in/a/1.off")},
          "is an OFF mesh");
  refused({"retrieve", "evaluate", path("s.h5"), "--csv", path("m.bin")}, "is a matrix of distances");
  write_file(path("mine.svg"), "x");
  refused({"retrieve", "evaluate", path("s.h5"), "--picture", path("mine.svg")}, "is a text file");
  refused({"retrieve", "evaluate", path("s.h5"), "--confusion", path("mine.svg")}, "is a text file");
  refused({"retrieve", "evaluate", path("s.h5"), "--picture", path("a.svg"), "--confusion", path("a.svg")},
          "would write the same file");
  refused({"retrieve", "query", path("s.h5"), "0", "--csv", path("c.png")}, "is a PNG picture");
  refused({"retrieve", "select", path("s.h5"), "--csv", path("p.svg")}, "is an SVG drawing");
  refused({"retrieve", "query", path("s.h5"), "0", "--csv", path("s.h5")}, "is the store itself");
}

TEST_CASE("outputs: measure does not change the points that it reads") {
  const Place place;
  fs::create_hard_link(place.path("points.csv"), place.path("result.csv"));
  const std::vector<std::string> measure = {"measure",   "spacing", place.path("points.csv"),
                                            "--surface", "plane",   "--csv"};
  const auto with = [&](const std::string& name) {
    std::vector<std::string> arguments = measure;
    arguments.push_back(place.path(name));
    return arguments;
  };
  place.refuses(with("points.csv"), "is an input of this command");
  place.refuses(with("result.csv"), "is an input of this command");
  place.refuses(with("m.off"), "is an OFF mesh");
  place.does(with("new.csv"));
  place.does(with("new.csv"));
  place.refuses({"measure", "spacing", place.path("s.h5") + "::torus", "--surface", place.path("m.off"),
                 "--csv", place.path("s.h5")},
                "is an input of this command");
  place.refuses({"measure", "spectrum", place.path("points.csv"), "--surface", "plane", "--picture",
                 place.path("notes.txt")},
                "is a text file");
}

TEST_CASE("outputs: figures replace only figures") {
  if (sanitized) {
    WARN("skipped: a sanitized build has no library for Python");
    return;
  }
  const Place place;
  const std::vector<std::string> figures = {"figures", "-o", place.path("f"), "--only", "1", "--quick"};
  fs::create_directory(place.path("f"));
  write_file(place.path("f/index.html"), "my list of links\n");
  place.refuses(figures, "is no HTML file of figures");
  fs::remove(place.path("f/index.html"));
  write_file(place.path("f/figure03_curves.svg"), "v 0 0 0\n");
  place.refuses(figures, "is no SVG file of figures");
  fs::remove(place.path("f/figure03_curves.svg"));
  write_file(place.path("f/other.svg"), "stays");
  place.does(figures);
  place.does(figures);
  CHECK(read_file(place.path("f/other.svg")) == "stays");
  fs::copy_file(place.path("m.off"), place.path("f/figure12_m.ply"));
  place.refuses(figures, "is no PLY file of figures");
}

namespace {

// Ends of standard output and standard error in a child.
enum class End { closed_pipe, full_disk, nothing };

ProcessOptions ending_in(End out, End error) {
  ProcessOptions options;
  options.in_child = [out, error] {
    const auto connect = [](End end, int number) {
      if (end == End::closed_pipe) {
        int ends[2];
        if (::pipe(ends) != 0) _exit(99);
        ::dup2(ends[1], number);
        ::close(ends[0]);
        ::close(ends[1]);
      } else if (end == End::full_disk) {
        const int full = ::open("/dev/full", O_WRONLY);
        ::dup2(full, number);
        ::close(full);
      } else {
        ::close(number);
      }
    };
    connect(out, STDOUT_FILENO);
    connect(error, STDERR_FILENO);
  };
  return options;
}

// One good model among many that fail with a status: their list is longer than any pipe buffer.
void write_failing(const fs::path& folder) {
  fs::create_directory(folder);
  write_mesh(folder / "good.off", icosphere(1));
  for (int i = 0; i < 200; ++i)
    write_file(folder / ("a_rather_long_name_of_a_model_" + std::to_string(i) + ".off"), "OFF\n0 0 0\n");
}

}  // namespace

TEST_CASE("closed pipes: a command ends as if its output had been read") {
  const ScratchFolder scratch;
  write_failing(scratch / "in");
  const auto run = [&](const std::string& store) {
    return std::vector<std::string>{"run", scratch / "in", "-o",         scratch / store, "-n",
                                    "16",  "--json",       "--progress", "plain"};
  };
  REQUIRE(meander_with(run("calm.h5")).exit_code == 3);
  int number = 0;
  for (const End error : {End::closed_pipe, End::nothing})
    for (const End out : {End::closed_pipe, End::nothing}) {
      const std::string store = "s" + std::to_string(number++) + ".h5";
      const ProcessResult result = meander_with(run(store), ending_in(out, error));
      CHECK(result.signal == 0);
      CHECK(result.exit_code == 3);
      CHECK((read_file(scratch / store) == read_file(scratch / "calm.h5")));
    }
  const std::vector<std::string> info = {"info", scratch / "calm.h5", "--failed"};
  REQUIRE(meander_with(info).out.size() > (std::size_t{1} << 13));
  CHECK(meander_with(info, ending_in(End::closed_pipe, End::closed_pipe)).exit_code == 0);
  CHECK(meander_with({"info", scratch / "calm.h5", "--json"}, ending_in(End::closed_pipe, End::closed_pipe))
            .exit_code == 0);
  CHECK(meander_with({"--help"}, ending_in(End::closed_pipe, End::closed_pipe)).exit_code == 0);
}

TEST_CASE("a full disk behind standard output is reported, however short the output") {
  const ScratchFolder scratch;
  const std::string store = scratch / "s.h5";
  REQUIRE(meander_with({"surface", "torus", "-n", "16", "-o", store}).exit_code == 0);
  ProcessOptions options;
  options.in_child = [] {
    const int full = ::open("/dev/full", O_WRONLY);
    ::dup2(full, STDOUT_FILENO);
  };
  const ProcessResult result = meander_with({"info", store}, options);
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, "No space left on device"));
}

TEST_CASE("export: no id of a store leads out of the folder") {
  for (std::string id : {"../evil", "/evil", "a/../../evil", "..", "a/.."}) {
    const ScratchFolder scratch;
    if (id.starts_with('/')) id = scratch / "evil";  // in the folder that is compared below
    fs::create_directory(scratch / "deep");
    const fs::path store = scratch / "deep/s.h5";
    StoreHeader header;
    header.samples = 1;
    header.parameters_json = "{}";
    header.ids = {id, "good.off"};
    std::sort(header.ids.begin(), header.ids.end());
    header.labels = {-1, -1};
    {
      RunDirectory directory(store, header);
      for (std::uint64_t row = 0; row < 2; ++row) {
        directory.begin_item(row);
        directory.end_item(encode_row(header, row, row_of_one_sample()));
      }
      directory.finish();
    }
    const auto before = content_of(scratch.path());
    const ProcessResult result = meander_with({"export", store, "-o", scratch / "deep/out"});
    INFO(id << ": " << result.err);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.err, "names a file outside"));
    CHECK((content_of(scratch.path()) == before));
    CHECK(meander_with({"export", store, "good.off", "-o", scratch / "deep/out"}).exit_code == 0);
    CHECK(fs::exists(scratch / "deep/out/good.off.ply"));
  }
}

TEST_CASE("run: the summary reports an attribute that no model has") {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "in");
  write_mesh(scratch / "in/a.off", icosphere(1));
  write_mesh(scratch / "in/b.ply", cube());
  write_file(scratch / "in/empty.off", "");
  const auto run = [&](const std::string& store, const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"run", scratch / "in", "-o", scratch / store, "-n", "16"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return meander_with(arguments);
  };
  const std::string words = "no model has what the command names";
  ProcessResult result = run("s.h5", {"--density", "attribute:heat"});
  INFO(result.out << result.err);
  CHECK(result.exit_code == 3);
  CHECK(contains(result.out, words + ": the density names the vertex attribute \"heat\""));
  CHECK(StoreReader(scratch / "s.h5").report(0).status == Status::missing_attribute);
  CHECK(StoreReader(scratch / "s.h5").report(1).status == Status::missing_attribute);
  CHECK(contains(run("j.h5", {"--density", "attribute:heat", "--json"}).out, "\"notice\":\"" + words));
  result = run("t.h5", {"--method", "anisotropic", "--tensor", "face-attribute:grain"});
  CHECK(contains(result.out, words + ": the tensor field needs the face attributes grain_xx"));
  // No message when at least one model has it.
  PolygonMesh with = cube();
  with.vertex_attributes = {{"heat", std::vector<double>(with.vertex_count(), 1.0)}};
  write_mesh(scratch / "in/c.ply", with);
  CHECK_FALSE(contains(run("c.h5", {"--density", "attribute:heat"}).out, words));
}

TEST_CASE("run: reports beside the store are complete, or the command names the missing ones") {
  const ScratchFolder scratch;
  write_failing(scratch / "in");
  const auto run = [&](const std::string& store, const ProcessOptions& options = {}) {
    return meander_with({"run", scratch / "in", "-o", scratch / store, "-n", "16"}, options);
  };
  REQUIRE(run("calm.h5").exit_code == 3);
  const auto list = read_file(scratch / "calm.h5.failed.txt");
  CHECK(std::count(list.begin(), list.end(), '\n') == 400);
  CHECK(read_file(scratch / "calm.h5.run.json").ends_with("}\n"));
  // A folder has the name of the list.
  fs::create_directory(scratch / "s.h5.failed.txt");
  const ProcessResult result = run("s.h5");
  CHECK(result.exit_code == 2);
  CHECK(contains(result.err, "s.h5.failed.txt"));
}
