#include "jobs/inputs.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "io/item_id.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

InputOptions labelled_by_folder() {
  InputOptions options;
  options.label_from_folder = true;
  return options;
}

void put_file(const fs::path& path, std::string_view bytes = {}) {
  fs::create_directories(path.parent_path());
  write_file(path, bytes);
}

std::vector<std::string> ids_of(const Inputs& inputs) {
  std::vector<std::string> ids;
  for (const PlanItem& item : inputs.items) ids.push_back(item.id);
  return ids;
}

using Ids = std::vector<std::string>;

// Class and split of every item, as `id class split`.
Ids labels_of(const Inputs& inputs) {
  Ids lines;
  for (const PlanItem& item : inputs.items)
    lines.push_back(item.id + " " +
                    (item.label < 0 ? "-" : inputs.label_names[static_cast<std::size_t>(item.label)]) + " " +
                    std::string(name_of(item.split)));
  return lines;
}

std::string message_of(const std::vector<std::string>& arguments, const InputOptions& options = {}) {
  try {
    collect_inputs(arguments, options);
  } catch (const UsageError& error) {
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("collect_inputs: ids are paths with extension, sorted by bytes, other files are counted") {
  const ScratchFolder scratch;
  for (const char* name :
       {"b/x.OFF", "b/a.obj", "Z.stl", "b/c/deep.Ply", "readme.md", "data.csv", "more.csv"}) {
    std::filesystem::create_directories((scratch / name).parent_path());
    write_file(scratch / name, "");
  }
  const Inputs inputs = collect_inputs({scratch.path().string()}, labelled_by_folder());
  REQUIRE(inputs.items.size() == 4);
  CHECK(inputs.items[0].id == "Z.stl");
  CHECK(inputs.items[1].id == "b/a.obj");
  CHECK(inputs.items[2].id == "b/c/deep.Ply");
  CHECK(inputs.items[3].id == "b/x.OFF");
  CHECK(inputs.items[3].row == 3);
  CHECK(inputs.notes.skipped.at(".csv") == 2);
  CHECK(inputs.label_names[static_cast<std::size_t>(inputs.items[2].label)] == "c");
}

TEST_CASE("collect_inputs: several folders are distinguished by their names, equal ids are refused") {
  const ScratchFolder scratch;
  for (const char* name : {"one/x.off", "two/x.off", "deep/one/x.off"}) {
    std::filesystem::create_directories((scratch / name).parent_path());
    write_file(scratch / name, "");
  }
  const Inputs inputs = collect_inputs({(scratch / "one").string(), (scratch / "two").string() + "/"});
  REQUIRE(inputs.items.size() == 2);
  CHECK(inputs.items[0].id == "one/x.off");
  CHECK(inputs.items[0].label == -1);
  CHECK_THROWS_AS(collect_inputs({(scratch / "one").string(), (scratch / "deep/one").string()}), UsageError);
  CHECK_THROWS_AS(collect_inputs({(scratch / "nowhere").string()}), UsageError);
}

TEST_CASE("collect_inputs: a file named explicitly always makes a row, lists keep their paths") {
  const ScratchFolder scratch;
  write_file(scratch / "strange.xyz", "");
  write_file(scratch / "list.txt", "\xef\xbb\xbf# comment\n\n \t\r\nsome/where/a.off\r\n./b.obj\n");
  const Inputs inputs =
      collect_inputs({(scratch / "strange.xyz").string(), "@" + (scratch / "list.txt").string()});
  REQUIRE(inputs.items.size() == 3);
  CHECK(inputs.items[0].id == "b.obj");
  CHECK(inputs.items[1].id == "some/where/a.off");
  CHECK(inputs.items[2].id == "strange.xyz");
  CHECK_FALSE(inputs.items[2].known_format);
}

TEST_CASE("collect_inputs: Princeton classifications give labels and files of the database") {
  const ScratchFolder scratch;
  std::filesystem::create_directories(scratch / "db/1/m123");
  write_file(scratch / "db/1/m123/m123.off", "");
  write_file(scratch / "test.cla", "PSB 1\n3 3\n\nanimal 0 0\n\ndog animal 2\n123\n7\n\nplane 0 1 250\n");
  const Inputs inputs = collect_inputs({(scratch / "test.cla").string()});
  REQUIRE(inputs.items.size() == 3);
  CHECK(inputs.items[0].id == "db/0/m7/m7.off");
  CHECK(inputs.items[1].id == "db/1/m123/m123.off");
  CHECK(inputs.label_names == std::vector<std::string>{"dog", "plane"});
  CHECK(inputs.items[1].label == 0);
  CHECK(inputs.items[2].label == 1);
  CHECK(std::filesystem::exists(inputs.items[1].path));
  write_file(scratch / "bad.cla", "PSB 1\n1 5\ndog 0 2 1 2\n");
  CHECK_THROWS_AS(collect_inputs({(scratch / "bad.cla").string()}), UsageError);
}

using Catch::Matchers::Contains;

TEST_CASE("collect_inputs: links to folders and files are followed, each link is a row") {
  const ScratchFolder scratch;
  put_file(scratch / "real/chair/a.off");
  put_file(scratch / "real/chair/deep/b.off");
  put_file(scratch / "real/one.off");
  fs::create_directories(scratch / "set");
  fs::create_directory_symlink("../real/chair", scratch / "set/chair");
  fs::create_directory_symlink(scratch / "real/chair", scratch / "set/again");
  fs::create_symlink("../real/one.off", scratch / "set/one.off");
  fs::create_symlink("../real/one.off", scratch / "set/two.off");
  const Inputs inputs = collect_inputs({(scratch / "set").string()});
  CHECK(ids_of(inputs) ==
        Ids{"again/a.off", "again/deep/b.off", "chair/a.off", "chair/deep/b.off", "one.off", "two.off"});
  CHECK(inputs.notes.unread.empty());
  CHECK(inputs.notes.links_back == 0);
}

TEST_CASE("collect_inputs: links that lead back end, and are counted") {
  const ScratchFolder scratch;
  put_file(scratch / "set/a/x.off");
  put_file(scratch / "set/b/y.off");
  fs::create_directory_symlink(".", scratch / "set/a/self");
  fs::create_directory_symlink("..", scratch / "set/a/up");
  fs::create_directory_symlink("../a", scratch / "set/b/to_a");
  fs::create_directory_symlink("../b", scratch / "set/a/to_b");
  const Inputs inputs = collect_inputs({(scratch / "set").string()});
  CHECK(ids_of(inputs) == Ids{"a/to_b/y.off", "a/x.off", "b/to_a/x.off", "b/y.off"});
  CHECK(inputs.notes.links_back == 6);
  CHECK(inputs.notes.unread.empty());
}

TEST_CASE(
    "collect_inputs: what a broken link may have held is named, and one that ends like a mesh is a row") {
  const ScratchFolder scratch;
  put_file(scratch / "set/a.off");
  fs::create_symlink("nowhere", scratch / "set/chair");
  fs::create_symlink("loop", scratch / "set/loop");
  fs::create_symlink("nowhere.off", scratch / "set/gone.off");
  const Inputs inputs = collect_inputs({(scratch / "set").string()});
  CHECK(ids_of(inputs) == Ids{"a.off", "gone.off"});
  REQUIRE(inputs.notes.unread.size() == 2);
  CHECK(inputs.notes.unread[0].path == scratch / "set/chair");
  CHECK(inputs.notes.unread[0].reason == "the target of the link does not exist");
  CHECK(inputs.notes.unread[1].path == scratch / "set/loop");
  CHECK_THAT(inputs.notes.unread[1].reason, Contains("symbolic links"));
}

TEST_CASE("collect_inputs: a folder that cannot be read is named, the others are searched") {
  const ScratchFolder scratch;
  put_file(scratch / "set/open/a.off");
  put_file(scratch / "set/closed/b.off");
  fs::permissions(scratch.path(), fs::perms::all);
  fs::permissions(scratch / "set/closed", fs::perms::none);
  // Root ignores permissions: the search runs as another user, in a process of its own.
  const ::pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    if (::geteuid() == 0 && ::seteuid(65534) != 0) ::_exit(77);
    // The temporary folder may lie below one that is closed to that user.
    if (::faccessat(AT_FDCWD, scratch.path().c_str(), X_OK, AT_EACCESS) != 0) ::_exit(77);
    const Inputs inputs = collect_inputs({(scratch / "set").string()});
    const bool right = ids_of(inputs) == Ids{"open/a.off"} && inputs.notes.unread.size() == 1 &&
                       inputs.notes.unread[0].path == scratch / "set/closed" &&
                       inputs.notes.unread[0].reason == "Permission denied";
    ::_exit(right ? 0 : 1);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  fs::permissions(scratch / "set/closed", fs::perms::owner_all);
  REQUIRE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77)
    WARN("skipped: cannot become another user, or one that reaches the temporary folder");
  else
    CHECK(WEXITSTATUS(status) == 0);
}

TEST_CASE("collect_inputs: hidden files and folders are left out and counted, but not when they are named") {
  const ScratchFolder scratch;
  for (const char* name : {"set/a.off", "set/._a.off", "set/.hidden.off", "set/.git/b.off", "set/.git/c.off",
                           "set/__MACOSX/a.off"})
    put_file(scratch / name);
  const Inputs inputs = collect_inputs({(scratch / "set").string()});
  CHECK(ids_of(inputs) == Ids{"a.off"});
  CHECK(inputs.notes.hidden == 4);
  CHECK(inputs.notes.skipped.empty());
  CHECK(ids_of(collect_inputs({(scratch / "set/.git").string()})) == Ids{"b.off", "c.off"});
  CHECK(ids_of(collect_inputs({(scratch / "set/.hidden.off").string()})) == Ids{".hidden.off"});
}

TEST_CASE("collect_inputs: any file name is an id of valid UTF-8") {
  const ScratchFolder scratch;
  for (const char* name :
       {"caf\xE9.off", "caf\xC3\xA9.off", "line\nbreak.off", "50%.off", "a%20b.off", "c%0A.off"})
    put_file(scratch / "set" / name);
  const Inputs inputs = collect_inputs({(scratch / "set").string()}, labelled_by_folder());
  CHECK(ids_of(inputs) ==
        Ids{"50%.off", "a%20b.off", "c%250A.off", "caf%E9.off", "caf\xC3\xA9.off", "line%0Abreak.off"});
  for (const PlanItem& item : inputs.items) CHECK(scratch / "set" / unescape_id(item.id) == item.path);
  put_file(scratch / "set/\xFF%FF/x.off");
  const Inputs deep = collect_inputs({(scratch / "set/\xFF%FF").string()}, labelled_by_folder());
  CHECK(deep.label_names == Ids{"%FF%25FF"});
}

TEST_CASE("collect_inputs: ids of lists are relative to the folder that all paths have in common") {
  const ScratchFolder scratch;
  const auto list_of = [&](const std::string& name, const std::vector<std::string>& paths, char end) {
    std::string text;
    for (const std::string& path : paths) text += path + end;
    write_file(scratch / name, text);
    return "@" + (scratch / name).string();
  };
  const std::string here = list_of("here", {"/data/here/chair/a.off", "/data/here/x/../table/b.off"}, '\n');
  const std::string there = list_of("there", {"/mnt/7/chair/a.off", "/mnt/7/table/b.off"}, '\n');
  const Inputs inputs = collect_inputs({here});
  CHECK(ids_of(inputs) == Ids{"chair/a.off", "table/b.off"});
  CHECK(inputs.root == "/data/here");
  CHECK(ids_of(collect_inputs({there})) == ids_of(inputs));
  // Two lists have one root.
  CHECK(ids_of(collect_inputs({here, there})) ==
        Ids{"data/here/chair/a.off", "data/here/table/b.off", "mnt/7/chair/a.off", "mnt/7/table/b.off"});

  InputOptions rooted;
  rooted.root = "/data/";
  CHECK(ids_of(collect_inputs({here}, rooted)) == Ids{"here/chair/a.off", "here/table/b.off"});
  CHECK(collect_inputs({here}, rooted).root == "/data");
  CHECK_THAT(message_of({there}, rooted),
             Contains("`/mnt/7/chair/a.off` is outside `/data`") && Contains("--root"));

  // A list that grows keeps its root, and its ids.
  InputOptions grown;
  grown.remembered_root = inputs.root;
  const std::string more = list_of("more", {"/data/here/chair/a.off"}, '\n');
  CHECK(ids_of(collect_inputs({more}, grown)) == Ids{"chair/a.off"});
  CHECK(ids_of(collect_inputs({more})) == Ids{"a.off"});
  CHECK_THAT(message_of({there}, grown),
             Contains("outside `/data/here`") && Contains("since the store was made"));
  grown.root = "/mnt";
  CHECK(ids_of(collect_inputs({there}, grown)) == Ids{"7/chair/a.off", "7/table/b.off"});

  CHECK_THAT(message_of({"."}, rooted), Contains("--root applies to lists"));
  CHECK(collect_inputs({scratch.path().string()}).root.empty());
}

TEST_CASE("collect_inputs: lists apart by NUL bytes hold any path") {
  const ScratchFolder scratch;
  using namespace std::string_view_literals;
  const std::string_view bytes = "/d/a\n1.off\0/d/# b \r\0\0/d/e/c.off"sv;
  write_file(scratch / "list", bytes);
  InputOptions options;
  options.null_lists = true;
  const Inputs inputs = collect_inputs({"@" + (scratch / "list").string()}, options);
  CHECK(ids_of(inputs) == Ids{"# b %0D", "a%0A1.off", "e/c.off"});
  CHECK(inputs.items[1].path == "/d/a\n1.off");
  CHECK_THAT(message_of({"@" + (scratch / "list").string()}), Contains("NUL") && Contains("--null"));
  CHECK_THAT(message_of({scratch.path().string()}, options), Contains("--null applies to lists"));
}

TEST_CASE("folder layouts: class and split of an item") {
  const auto place = [](std::string_view id, FolderLayout layout) {
    const ItemPlace found = place_of(id, layout);
    return (found.label.empty() ? "-" : found.label) + " " + std::string(name_of(found.split));
  };
  using enum FolderLayout;
  CHECK(place("chair/train/x.off", modelnet) == "chair train");
  CHECK(place("ModelNet40/night_stand/Test/x.off", modelnet) == "night_stand test");
  CHECK(place("train/chair/x.off", modelnet) == "chair train");
  CHECK(place("top/val/chair/x.off", modelnet) == "chair validation");
  CHECK(place("test/validation/x.off", modelnet) == "test validation");
  CHECK(place("train/x.off", modelnet) == "- train");
  CHECK(place("chair/x.off", modelnet) == "- none");
  CHECK(place("train", modelnet) == "- none");
  CHECK(place("02691156/1a04/models/model_normalized.obj", shapenet) == "02691156 none");
  CHECK(place("v2/02691156/1a04/models/model_normalized.obj", shapenet) == "02691156 none");
  CHECK(place("02691156/1a04/model.obj", shapenet) == "02691156 none");
  CHECK(place("1a04/x.obj", shapenet) == "- none");
  CHECK(place("models/x.obj", shapenet) == "- none");
  CHECK(place("x.obj", shapenet) == "- none");
  CHECK(place("chair/train/x.off", flat) == "- none");
}

TEST_CASE("folder layouts: auto needs every item to fit") {
  const auto layout = [](const Ids& ids) { return recognise_layout(ids); };
  using enum FolderLayout;
  CHECK(layout({"chair/test/1.off", "chair/train/2.off"}) == modelnet);
  CHECK(layout({"m/chair/test/1.off", "m/lamp/train/2.off", "m/lamp/val/3.off"}) == modelnet);
  CHECK(layout({"test/chair/1.off", "train/lamp/2.off"}) == modelnet);
  CHECK(layout({"chair/test/1.off", "chair/train/2.off", "readme.off"}) == flat);
  CHECK(layout({"chair/test/1.off", "train/chair/2.off"}) == flat);
  CHECK(layout({"assimp/test/1.off", "meshlab/test/2.off"}) == flat);
  CHECK(layout({"test/1.off", "train/2.off"}) == flat);
  CHECK(layout({"02691156/1a/models/model_normalized.obj", "03001627/2b/models/m.obj"}) == shapenet);
  CHECK(layout({"02691156/1a/model.obj", "03001627/2b/model.obj"}) == shapenet);
  CHECK(layout({"0269115/1a/models/model_normalized.obj"}) == flat);
  CHECK(layout({"chair/a.off", "lamp/b.off"}) == flat);
  CHECK(layout({}) == flat);
}

TEST_CASE("collect_inputs: a labelled tree gives classes and splits") {
  const ScratchFolder scratch;
  for (const char* name : {"m/chair/train/a.off", "m/chair/test/b.off", "m/lamp/train/c.off"})
    put_file(scratch / name);
  const std::string tree = (scratch / "m").string();
  const Ids expected = {"chair/test/b.off chair test", "chair/train/a.off chair train",
                        "lamp/train/c.off lamp train"};
  const Inputs inputs = collect_inputs({tree});
  CHECK(labels_of(inputs) == expected);
  CHECK(inputs.label_names == Ids{"chair", "lamp"});
  CHECK(inputs.notes.layout == FolderLayout::modelnet);
  // What is named beside the tree does not disturb it.
  put_file(scratch / "extra.off");
  CHECK(collect_inputs({tree, (scratch / "extra.off").string()}).notes.layout == FolderLayout::modelnet);
  InputOptions flat = labelled_by_folder();
  flat.layout = FolderLayout::flat;
  CHECK(labels_of(collect_inputs({tree}, flat)) ==
        Ids{"chair/test/b.off test none", "chair/train/a.off train none", "lamp/train/c.off train none"});
  // One file that does not fit: nothing is guessed, but modelnet can be asked for.
  put_file(scratch / "m/spare.off");
  CHECK(collect_inputs({tree}).notes.layout == FolderLayout::flat);
  InputOptions asked = labelled_by_folder();
  asked.layout = FolderLayout::modelnet;
  Ids more = expected;
  more.push_back("spare.off m none");
  CHECK(labels_of(collect_inputs({tree}, asked)) == more);
}

TEST_CASE("collect_inputs: a file of labels says more than the folders") {
  const ScratchFolder scratch;
  for (const char* name : {"m/a.off", "m/b, \"c\".off", "m/d.off", "m/e\xFF.off"}) put_file(scratch / name);
  const std::string tree = (scratch / "m").string(), file = (scratch / "labels.csv").string();
  InputOptions options = labelled_by_folder();
  options.labels = file;
  const auto labels = [&](const std::string& csv) {
    write_file(file, csv);
    return labels_of(collect_inputs({tree}, options));
  };
  CHECK(labels("\xEF\xBB\xBF"
               "a.off,chair,train\r\n\r\n\"b, \"\"c\"\".off\" , big lamp\ne%FF.off,,Val\nzz.off,chair") ==
        Ids{"a.off chair train", "b, \"c\".off big lamp none", "d.off m none", "e%FF.off m validation"});
  const Inputs inputs = collect_inputs({tree}, options);
  CHECK(inputs.notes.has_label_file);
  CHECK(inputs.notes.lines_without_item == 1);
  CHECK(inputs.notes.items_without_line == 1);
  CHECK(inputs.label_names == Ids{"big lamp", "chair", "m"});
  // A header names the columns; the path may stand for the id.
  CHECK(labels("split,colour,ID,Class\ntest,red,d.off,lamp\ntrain,,e\xFF.off,lamp\n").back() ==
        "e%FF.off lamp train");
  // A repeated line is not a conflict.
  CHECK(labels("a.off,chair,train\na.off,chair,train\n").front() == "a.off chair train");
  // A class with a line end is one class.
  CHECK(labels("a.off,\"two\nlines\"\n").front() == "a.off two%0Alines none");
}

TEST_CASE("collect_inputs: a wrong file of labels is refused with the line") {
  const ScratchFolder scratch;
  put_file(scratch / "m/a.off");
  const std::string tree = (scratch / "m").string();
  InputOptions options;
  options.labels = (scratch / "labels.csv").string();
  const auto refusal = [&](const std::string& csv) {
    write_file(options.labels, csv);
    return message_of({tree}, options);
  };
  CHECK_THAT(refusal("a.off,chair\nb.off,lamp\na.off,lamp\n"),
             Contains("line 3") && Contains("`a.off` than in line 1"));
  CHECK_THAT(refusal("a.off,chair,train\na.off,chair,test\n"), Contains("line 2"));
  CHECK_THAT(refusal("a.off,chair,later\n"), Contains("line 1") && Contains("`later`"));
  CHECK_THAT(refusal("x.off,c\n\na.off\n"), Contains("line 3") && Contains("1 fields"));
  CHECK_THAT(refusal("a.off,b,train,d\n"), Contains("4 fields"));
  CHECK_THAT(refusal("\"x\ny.off\",c\na.off,\"chair\n"), Contains("line 3") && Contains("not closed"));
  CHECK_THAT(refusal("\"a\"b,c\n"), Contains("closing quotation mark"));
  CHECK_THAT(refusal("id,colour\na.off,red\n"), Contains("`class`"));
  CHECK_THAT(refusal("id,class,split\na.off,red\n"), Contains("2 fields, must be 3"));
  options.labels = (scratch / "absent.csv").string();
  CHECK_THAT(message_of({tree}, options), Contains("cannot read"));
  options.labels = tree;
  CHECK_THAT(message_of({tree}, options), Contains("cannot read"));
}
