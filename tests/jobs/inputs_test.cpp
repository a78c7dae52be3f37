#include "jobs/inputs/inputs.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "io/item_id.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/item_names.h"
#include "support/archive_files.h"
#include "support/catch.h"
#include "support/mesh_files.h"
#include "support/test_meshes.h"

using namespace meander;
using namespace meander::test;

namespace {

namespace fs = std::filesystem;

InputOptions labeled_by_folder() {
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
  const Inputs inputs = collect_inputs({scratch.path().string()}, labeled_by_folder());
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

TEST_CASE("collect_inputs: an explicitly named file always makes a row, lists keep their paths") {
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

TEST_CASE("collect_inputs: Princeton classifications give labels and the files of the database") {
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
  write_file(scratch / "marked.cla", "\xEF\xBB\xBF" + read_file(scratch / "test.cla"));
  CHECK(collect_inputs({(scratch / "marked.cla").string()}).label_names == inputs.label_names);
  write_file(scratch / "bad.cla", "PSB 1\n1 5\ndog 0 2 1 2\n");
  CHECK_THROWS_AS(collect_inputs({(scratch / "bad.cla").string()}), UsageError);
}

using Catch::Matchers::ContainsSubstring;

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

TEST_CASE("collect_inputs: cyclic links end, and are counted") {
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

TEST_CASE("collect_inputs: broken links are named, and one with a mesh extension is a row") {
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
  CHECK_THAT(inputs.notes.unread[1].reason, ContainsSubstring("symbolic links"));
}

TEST_CASE("collect_inputs: an unreadable folder is named, the others are searched") {
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

TEST_CASE("collect_inputs: hidden files and folders are skipped and counted, unless named explicitly") {
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

TEST_CASE("collect_inputs: any file name gives an id of valid UTF-8") {
  const ScratchFolder scratch;
  for (const char* name :
       {"caf\xE9.off", "caf\xC3\xA9.off", "line\nbreak.off", "50%.off", "a%20b.off", "c%0A.off"})
    put_file(scratch / "set" / name);
  const Inputs inputs = collect_inputs({(scratch / "set").string()}, labeled_by_folder());
  CHECK(ids_of(inputs) ==
        Ids{"50%.off", "a%20b.off", "c%250A.off", "caf%E9.off", "caf\xC3\xA9.off", "line%0Abreak.off"});
  for (const PlanItem& item : inputs.items) CHECK(scratch / "set" / unescape_id(item.id) == item.path);
  put_file(scratch / "set/\xFF%FF/x.off");
  const Inputs deep = collect_inputs({(scratch / "set/\xFF%FF").string()}, labeled_by_folder());
  CHECK(deep.label_names == Ids{"%FF%25FF"});
}

TEST_CASE("collect_inputs: ids of lists are relative to the folder that all paths share") {
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
             ContainsSubstring("`/mnt/7/chair/a.off` is outside `/data`") && ContainsSubstring("--root"));

  // A list that grows keeps its root, and its ids.
  InputOptions grown;
  grown.remembered_root = inputs.root;
  const std::string more = list_of("more", {"/data/here/chair/a.off"}, '\n');
  CHECK(ids_of(collect_inputs({more}, grown)) == Ids{"chair/a.off"});
  CHECK(ids_of(collect_inputs({more})) == Ids{"a.off"});
  CHECK_THAT(message_of({there}, grown),
             ContainsSubstring("outside `/data/here`") && ContainsSubstring("since the store was made"));
  grown.root = "/mnt";
  CHECK(ids_of(collect_inputs({there}, grown)) == Ids{"7/chair/a.off", "7/table/b.off"});

  CHECK_THAT(message_of({"."}, rooted), ContainsSubstring("--root applies to lists"));
  CHECK(collect_inputs({scratch.path().string()}).root.empty());
}

TEST_CASE("collect_inputs: lists separated by NUL bytes hold any path") {
  const ScratchFolder scratch;
  using namespace std::string_view_literals;
  const std::string_view bytes = "/d/a\n1.off\0/d/# b \r\0\0/d/e/c.off"sv;
  write_file(scratch / "list", bytes);
  InputOptions options;
  options.null_lists = true;
  const Inputs inputs = collect_inputs({"@" + (scratch / "list").string()}, options);
  CHECK(ids_of(inputs) == Ids{"# b %0D", "a%0A1.off", "e/c.off"});
  CHECK(inputs.items[1].path == "/d/a\n1.off");
  CHECK_THAT(message_of({"@" + (scratch / "list").string()}),
             ContainsSubstring("NUL") && ContainsSubstring("--null"));
  CHECK_THAT(message_of({scratch.path().string()}, options), ContainsSubstring("--null applies to lists"));
}

TEST_CASE("folder layouts: give class and split of an item") {
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
  const auto layout = [](const Ids& ids) { return recognize_layout(ids); };
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

TEST_CASE("collect_inputs: a labeled tree gives classes and splits") {
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
  InputOptions flat = labeled_by_folder();
  flat.layout = FolderLayout::flat;
  CHECK(labels_of(collect_inputs({tree}, flat)) ==
        Ids{"chair/test/b.off test none", "chair/train/a.off train none", "lamp/train/c.off train none"});
  // One file that does not fit: nothing is guessed, but modelnet can be asked for.
  put_file(scratch / "m/spare.off");
  CHECK(collect_inputs({tree}).notes.layout == FolderLayout::flat);
  InputOptions asked = labeled_by_folder();
  asked.layout = FolderLayout::modelnet;
  Ids more = expected;
  more.push_back("spare.off m none");
  CHECK(labels_of(collect_inputs({tree}, asked)) == more);
}

TEST_CASE("collect_inputs: a label file overrides the folders") {
  const ScratchFolder scratch;
  for (const char* name : {"m/a.off", "m/b, \"c\".off", "m/d.off", "m/e\xFF.off"}) put_file(scratch / name);
  const std::string tree = (scratch / "m").string(), file = (scratch / "labels.csv").string();
  InputOptions options = labeled_by_folder();
  options.labels = {file};
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
  CHECK(labels("split,color,ID,Class\ntest,red,d.off,lamp\ntrain,,e\xFF.off,lamp\n").back() ==
        "e%FF.off lamp train");
  // A repeated line is not a conflict.
  CHECK(labels("a.off,chair,train\na.off,chair,train\n").front() == "a.off chair train");
  // A class with a line end is one class.
  CHECK(labels("a.off,\"two\nlines\"\n").front() == "a.off two%0Alines none");
}

TEST_CASE("collect_inputs: an invalid label file is refused with its line") {
  const ScratchFolder scratch;
  put_file(scratch / "m/a.off");
  const std::string tree = (scratch / "m").string();
  InputOptions options;
  options.labels = {(scratch / "labels.csv").string()};
  const auto refusal = [&](const std::string& csv) {
    write_file(options.labels[0], csv);
    return message_of({tree}, options);
  };
  CHECK_THAT(refusal("a.off,chair\nb.off,lamp\na.off,lamp\n"),
             ContainsSubstring("line 3") && ContainsSubstring("`a.off` than in line 1"));
  CHECK_THAT(refusal("a.off,chair,train\na.off,chair,test\n"), ContainsSubstring("line 2"));
  CHECK_THAT(refusal("a.off,chair,later\n"), ContainsSubstring("line 1") && ContainsSubstring("`later`"));
  CHECK_THAT(refusal("x.off,c\n\na.off\n"), ContainsSubstring("line 3") && ContainsSubstring("1 fields"));
  CHECK_THAT(refusal("a.off,b,train,d\n"), ContainsSubstring("4 fields"));
  CHECK_THAT(refusal("\"x\ny.off\",c\na.off,\"chair\n"),
             ContainsSubstring("line 3") && ContainsSubstring("not closed"));
  CHECK_THAT(refusal("\"a\"b,c\n"), ContainsSubstring("closing quotation mark"));
  CHECK_THAT(refusal("id,color\na.off,red\n"), ContainsSubstring("`class`"));
  CHECK_THAT(refusal("id,class,split\na.off,red\n"), ContainsSubstring("2 fields, must be 3"));
  options.labels = {(scratch / "absent.csv").string()};
  CHECK_THAT(message_of({tree}, options), ContainsSubstring("cannot read"));
  options.labels = {tree};
  CHECK_THAT(message_of({tree}, options), ContainsSubstring("cannot read"));
}

namespace {

// Labels of a tree whose files of labels are beside it.
class LabeledTree {
 public:
  explicit LabeledTree(const std::vector<std::string>& names) {
    for (const std::string& name : names) put_file(scratch_ / "in" / name);
  }
  const fs::path& folder() const { return scratch_.path(); }
  std::string in() const { return (scratch_ / "in").string(); }
  void write(const std::string& name, std::string_view text) const { put_file(scratch_ / name, text); }

  // `labels`: names of files below the folder, behind a split or alone.
  InputOptions options(const std::vector<std::string>& labels) const {
    InputOptions options;
    for (const std::string& label : labels) {
      const std::size_t equals = label.find('=');
      options.labels.push_back(equals == std::string::npos
                                   ? (scratch_ / label).string()
                                   : label.substr(0, equals + 1) +
                                         (scratch_ / label.substr(equals + 1)).string());
    }
    return options;
  }
  Inputs read(const std::vector<std::string>& labels) const {
    return collect_inputs({in()}, options(labels));
  }
  Ids lines(const std::vector<std::string>& labels) const { return labels_of(read(labels)); }
  std::string refusal(const std::vector<std::string>& labels) const {
    return message_of({in()}, options(labels));
  }

 private:
  ScratchFolder scratch_;
};

constexpr std::string_view taxonomy = R"([
  {"synsetId": "02691156", "name": "airplane,aeroplane,plane", "children": ["02690373"], "numInstances": 4045},
  {"synsetId": "02690373", "name": "airliner", "children": [], "numInstances": 1490},
  {"synsetId": "03001627", "name": "chair", "children": ["02738535"], "numInstances": 6778},
  {"synsetId": "02738535", "name": "chair,armchair", "children": [], "numInstances": 1995},
  {"synsetId": "02933112", "name": "cabinet", "children": [], "numInstances": 1571},
  {"synsetId": "03018349", "name": "cabinet,china closet", "children": [], "numInstances": 10}])";

}  // namespace

TEST_CASE("labels: all.csv of ShapeNet gives splits, and taxonomy.json the class names") {
  const std::vector<std::string> v2 = {
      "02691156/1a/models/model_normalized.obj", "03001627/1a/models/model_normalized.obj",
      "03001627/2b/models/model_normalized.obj", "03001627/3c/models/model_normalized.obj"};
  const std::string_view all =
      "id,synsetId,subSynsetId,modelId,split\n000001,02691156,02690373,1a,train\n"
      "000002,03001627,02738535,1a,val\n000003,03001627,03001627,2b,test\n000009,04379243,04379243,2b,test\n";
  const LabeledTree tree(v2);
  tree.write("all.csv", all);
  const auto lines = [&](const char* airplane, const char* chair, const std::string& end) {
    const std::string plane = airplane, seat = chair;
    return Ids{v2[0] + " " + plane + " train", v2[1] + " " + seat + " validation",
               v2[2] + " " + seat + " test", v2[3] + " " + seat + end};
  };
  // Without a taxonomy the classes are synsets, as those of the folders.
  CHECK(tree.lines({"all.csv"}) == lines("02691156", "03001627", " none"));
  const Inputs inputs = tree.read({"all.csv"});
  CHECK(inputs.notes.items_without_line == 1);
  CHECK(inputs.notes.item_without_line == v2[3]);
  CHECK(inputs.notes.lines_without_item == 1);
  CHECK_THAT(inputs.notes.line_without_item,
             ContainsSubstring("`04379243/2b`") && ContainsSubstring("all.csv` line 5"));
  CHECK(inputs.notes.ambiguous_lines == 0);
  CHECK(inputs.notes.class_names.empty());
  // In the root of the input, beside the file, or given itself.
  put_file(fs::path(tree.in()) / "taxonomy.json", taxonomy);
  const Ids named = lines("airplane", "chair", " none");
  CHECK(tree.lines({"all.csv"}) == named);
  CHECK(tree.read({"all.csv"}).notes.class_names == (fs::path(tree.in()) / "taxonomy.json").string());
  CHECK(tree.read({"all.csv"}).notes.named_items == 4);
  // Nothing is named unless it is asked for, but the summary says so.
  CHECK(tree.lines({}) == Ids{v2[0] + " 02691156 none", v2[1] + " 03001627 none", v2[2] + " 03001627 none",
                              v2[3] + " 03001627 none"});
  CHECK(tree.read({}).notes.unused_label_files == Ids{(fs::path(tree.in()) / "taxonomy.json").string()});
  fs::rename(fs::path(tree.in()) / "taxonomy.json", tree.folder() / "taxonomy.json");
  CHECK(tree.lines({"all.csv"}) == named);
  CHECK(tree.lines({"taxonomy.json"}) ==
        Ids{v2[0] + " airplane none", v2[1] + " chair none", v2[2] + " chair none", v2[3] + " chair none"});
  fs::create_directories(tree.folder() / "else");
  fs::rename(tree.folder() / "taxonomy.json", tree.folder() / "else/taxonomy.json");
  CHECK(tree.lines({"all.csv"}) == lines("02691156", "03001627", " none"));
  CHECK(tree.lines({"all.csv", "else/taxonomy.json"}) == named);
  // In an archive, at its top, in a folder of it and in an archive in it.
  std::vector<ArchiveEntry> packed(2);
  packed[0].name = "all.csv";
  packed[0].content = all;
  packed[1].name = "taxonomy.json";
  packed[1].content = taxonomy;
  tree.write("S.zip", zip_bytes(packed));
  CHECK(tree.lines({"S.zip/all.csv"}) == named);
  CHECK(tree.read({"S.zip/all.csv"}).notes.class_names == (tree.folder() / "S.zip/taxonomy.json").string());
  ArchiveEntry inner;
  inner.name = "in.zip";
  inner.content = zip_bytes(packed);
  tree.write("outer.tar", tar_bytes({inner}));
  CHECK(tree.lines({"outer.tar/in.zip/all.csv"}) == named);
  for (ArchiveEntry& entry : packed) entry.name = "lists/" + entry.name;
  packed.push_back(inner);
  tree.write("T.tar.gz", gzip_bytes(tar_bytes(packed)));
  CHECK(tree.lines({"T.tar.gz/lists/all.csv"}) == named);
  packed[1].name = "taxonomy.json";
  tree.write("T.tar.gz", gzip_bytes(tar_bytes(packed)));
  CHECK(tree.lines({"T.tar.gz/lists/all.csv"}) == lines("02691156", "03001627", " none"));
  // A synset alone as the input is that of its folder; the model of the other with the same number is not
  // there.
  const std::string chairs = tree.in() + "/03001627";
  CHECK(labels_of(collect_inputs({chairs}, tree.options({"all.csv"}))) ==
        Ids{"1a/models/model_normalized.obj 03001627 validation",
            "2b/models/model_normalized.obj 03001627 test", "3c/models/model_normalized.obj - none"});
}

TEST_CASE("labels: all.csv finds models in other layouts if their number is unique") {
  const std::string_view all =
      "id,synsetId,subSynsetId,modelId,split\n000001,02691156,02690373,1a,train\n"
      "000002,03001627,02738535,1a,val\n000003,03001627,03001627,2b,test\n";
  const LabeledTree v1({"02691156/1a/model.obj", "03001627/2b/model.obj"});
  v1.write("all.csv", all);
  CHECK(v1.lines({"all.csv"}) ==
        Ids{"02691156/1a/model.obj 02691156 train", "03001627/2b/model.obj 03001627 test"});
  const LabeledTree flat({"1a.obj", "2b.obj", "model_000002.obj"});
  flat.write("all.csv", all);
  // 1a is a model of two synsets: nothing says which.
  CHECK(flat.lines({"all.csv"}) ==
        Ids{"1a.obj - none", "2b.obj 03001627 test", "model_000002.obj 03001627 validation"});
  // A model that stands in another synset is another one.
  const LabeledTree other({"02691156/2b/model.obj"});
  other.write("all.csv", all);
  CHECK(other.lines({"all.csv"}) == Ids{"02691156/2b/model.obj 02691156 none"});
}

TEST_CASE("labels: class names are stable and distinguish synsets") {
  std::vector<std::string> names;
  for (const char* synset :
       {"02691156", "02690373", "03001627", "02738535", "02933112", "03018349", "09999999"})
    names.push_back(std::string(synset) + "/1a/models/m.obj");
  const LabeledTree tree(names);
  tree.write("taxonomy.json", taxonomy);
  CHECK(tree.read({"taxonomy.json"}).label_names == Ids{"09999999", "airliner", "airplane",
                                                        "cabinet 02933112", "cabinet 03018349", "chair",
                                                        "chair 02738535"});
  tree.write("synsetoffset2category.txt", "Airplane\t02691156\nBag\t02773838\nChair\t03001627\n");
  CHECK(tree.read({"synsetoffset2category.txt"}).label_names ==
        Ids{"02690373", "02738535", "02933112", "03018349", "09999999", "Airplane", "Chair"});
  CHECK_THAT(tree.refusal({"taxonomy.json", "synsetoffset2category.txt"}),
             ContainsSubstring("another name for the synset 02691156"));
  CHECK_THAT(tree.refusal({"train=taxonomy.json"}), ContainsSubstring("has no split"));
  tree.write("cut.json", taxonomy.substr(0, 100));
  CHECK_THAT(tree.refusal({"cut.json"}), ContainsSubstring("not valid JSON"));
}

TEST_CASE(
    "labels: tables without a class keep that of the folders, and columns are known by the names of data "
    "sets") {
  const LabeledTree tree(
      {"chair/train/chair_0001.off", "chair/test/chair_0002.off", "lamp/test/lamp_0001.off"});
  tree.write("splits.csv", "split,id\nval,chair_0001\ntrain,lamp_0001.off\n,chair_0002\n");
  CHECK(tree.lines({"splits.csv"}) == Ids{"chair/test/chair_0002.off chair test",
                                          "chair/train/chair_0001.off chair validation",
                                          "lamp/test/lamp_0001.off lamp train"});
  tree.write("metadata.csv",
             "object_id,class,split,object_path\nchair_0001,seat,train,chair/train/chair_0001.off\n");
  CHECK(tree.lines({"metadata.csv"})[1] == "chair/train/chair_0001.off seat train");
  // Two files that say different things of one item, also when each spells it otherwise.
  CHECK_THAT(
      tree.refusal({"splits.csv", "metadata.csv"}),
      ContainsSubstring("metadata.csv` line 2 gives `chair/train/chair_0001.off` another split than") &&
          ContainsSubstring("splits.csv` line 2"));
  tree.write("twice.csv", "chair_0001,seat\ntrain/chair_0001.off,stool\n");
  CHECK_THAT(tree.refusal({"twice.csv"}),
             ContainsSubstring("gives `chair/train/chair_0001.off` another class than"));
  // A file of ids, of which some are not there, is not taken for one of names.
  tree.write("ids.csv", "chair_0001.off,stool\nchair/train/chair_0001.off,seat\nchair_0002.off,stool\n");
  CHECK(tree.lines({"ids.csv"}) == Ids{"chair/test/chair_0002.off chair test",
                                       "chair/train/chair_0001.off seat train",
                                       "lamp/test/lamp_0001.off lamp test"});
  CHECK(tree.read({"ids.csv"}).notes.lines_without_item == 2);
  tree.write("colors.csv", "id,color\nchair_0001,red\n");
  CHECK_THAT(tree.refusal({"colors.csv"}),
             ContainsSubstring("no column `class`") && ContainsSubstring("no column `split`"));
  CHECK_THAT(tree.refusal({"test=metadata.csv"}), ContainsSubstring("line 2: the split is `train`"));
  tree.write("classes.csv", "chair_0001,seat\n");
  CHECK(tree.lines({"val=classes.csv"})[1] == "chair/train/chair_0001.off seat validation");
}

TEST_CASE("labels: comments in tables are one-field lines that begin with #") {
  const LabeledTree tree({"a.obj", "#b.obj"});
  tree.write("t.csv", "# made by hand\nid,class\n  # a comment\na.obj,chair\n#b.obj,lamp\n#\n");
  CHECK(tree.lines({"t.csv"}) == Ids{"#b.obj lamp none", "a.obj chair none"});
  CHECK(tree.read({"t.csv"}).notes.lines_without_item == 0);
  tree.write("plain.csv", "# no header\na.obj,chair\n");
  CHECK(tree.lines({"plain.csv"}) == Ids{"#b.obj - none", "a.obj chair none"});
  tree.write("bad.csv", "id,class\n# a comment\na.obj\n");
  CHECK_THAT(tree.refusal({"bad.csv"}), ContainsSubstring("line 3: 1 fields"));
}

TEST_CASE("labels: lists have one id per line, and the split of the argument or of the file name") {
  const LabeledTree tree({"airplane/airplane_0001.off", "airplane/airplane_0627.off",
                          "night_stand/night_stand_0001.off", "sofa/sofa_0001.off"});
  tree.write("modelnet40_train.txt",
             "\xEF\xBB\xBF"
             "airplane_0001\r\n# a comment, with a comma\r\n\r\nnight_stand_0001\r\n");
  tree.write("modelnet40_test.txt", "airplane_0627\nbathtub_0107\n");
  tree.write("ids.txt", "sofa_0001\n");
  const Ids expected = {"airplane/airplane_0001.off - train", "airplane/airplane_0627.off - test",
                        "night_stand/night_stand_0001.off - train", "sofa/sofa_0001.off - validation"};
  CHECK(tree.lines({"modelnet40_train.txt", "modelnet40_test.txt", "val=ids.txt"}) == expected);
  const Inputs inputs = tree.read({"modelnet40_train.txt", "modelnet40_test.txt"});
  CHECK(inputs.notes.items_without_line == 1);
  CHECK(inputs.notes.lines_without_item == 1);
  CHECK_THAT(inputs.notes.line_without_item,
             ContainsSubstring("`bathtub_0107`") && ContainsSubstring("modelnet40_test.txt` line 2"));
  CHECK_THAT(tree.refusal({"ids.txt"}),
             ContainsSubstring("this list of ids") && ContainsSubstring("--labels train="));
  tree.write("train_test.txt", "sofa_0001\n");
  CHECK_THAT(tree.refusal({"train_test.txt"}), ContainsSubstring("this list of ids"));
  tree.write("test.txt", "airplane_0001\n");
  CHECK_THAT(tree.refusal({"modelnet40_train.txt", "test.txt"}), ContainsSubstring("another split than"));
  // The split of an argument counts before the file's name, and lists of points name models.
  tree.write("filelist_test.txt", "airplane/airplane_0001.txt\n");
  CHECK(tree.lines({"train=filelist_test.txt"})[0] == "airplane/airplane_0001.off - train");
}

TEST_CASE("labels: an item may be named by any unique end of its path") {
  const std::string uid = "8476c4170df24cf5bbe6967222d1a42d";
  const LabeledTree tree({"glbs/000-023/" + uid + ".glb", "abc/00000002/00000002_1ffb_trimesh_001.obj",
                          "abc/00000003_aa11_trimesh_000.obj", "scans/scene0191_00/scene0191_00_vh_clean.ply",
                          "scans/scene0191_00/scene0191_00_vh_clean_2.ply",
                          "flat/scene0707_01_vh_clean_2.ply", "thingi/32770.stl", "future/0a1b/raw_model.obj",
                          "future/0a1b/normalized_model.obj", "gso/Shoe_1/meshes/model.obj",
                          "partnet/2780/objs/new-0.obj", "partnet/2780/objs/new-1.obj",
                          "partnet/2781/objs/new-0.obj", "m123/m123.off"});
  const auto train_of = [&](const std::string& ids) {
    tree.write("train.txt", ids);
    Ids found;
    for (const std::string& line : tree.lines({"train.txt"}))
      if (line.ends_with(" train")) found.push_back(line.substr(0, line.find(' ')));
    return found;
  };
  CHECK(train_of(uid) == Ids{"glbs/000-023/" + uid + ".glb"});
  CHECK(train_of("000-023/" + uid + ".glb") == Ids{"glbs/000-023/" + uid + ".glb"});
  CHECK(train_of("/data/sets/glbs/000-023/" + uid + ".glb") == Ids{"glbs/000-023/" + uid + ".glb"});
  CHECK(train_of("00000002") == Ids{"abc/00000002/00000002_1ffb_trimesh_001.obj"});
  CHECK(train_of("00000003") == Ids{"abc/00000003_aa11_trimesh_000.obj"});
  CHECK(train_of("scene0191_00").size() == 2);
  CHECK(train_of("scene0707_01") == Ids{"flat/scene0707_01_vh_clean_2.ply"});
  CHECK(train_of("32770") == Ids{"thingi/32770.stl"});
  CHECK(train_of("0a1b").size() == 2);
  CHECK(train_of("Shoe_1") == Ids{"gso/Shoe_1/meshes/model.obj"});
  CHECK(train_of("2780") == Ids{"partnet/2780/objs/new-0.obj", "partnet/2780/objs/new-1.obj"});
  CHECK(train_of("2781/objs/new-0") == Ids{"partnet/2781/objs/new-0.obj"});
  CHECK(train_of("m123") == Ids{"m123/m123.off"});
  // Nothing is guessed.
  CHECK(train_of("new-0").empty());
  CHECK(train_of("objs/new-0.obj").empty());
  CHECK(tree.read({"train.txt"}).notes.ambiguous_lines == 1);
  CHECK_THAT(tree.read({"train.txt"}).notes.ambiguous_line,
             ContainsSubstring("`objs/new-0.obj`") && ContainsSubstring("line 1"));
  CHECK(tree.read({"train.txt"}).notes.lines_without_item == 0);
  for (const char* none : {"32770.obj", "3277", "scene0191", "00000003_aa11", "2782/objs/new-0",
                           "other/32770.stl", "raw_model.off", "/", "."}) {
    INFO(none);
    CHECK(train_of(none).empty());
    CHECK(tree.read({"train.txt"}).notes.lines_without_item == 1);
  }
}

TEST_CASE("labels: a line for a missing model matches no other model") {
  const auto are_lacking = [](const LabeledTree& tree, const Ids& ids) {
    std::string list;
    for (const std::string& id : ids) list += id + "\n";
    tree.write("train.txt", list);
    const InputNotes notes = tree.read({"train.txt"}).notes;
    return notes.lines_without_item == ids.size() && notes.ambiguous_lines == 0;
  };
  CHECK(are_lacking(LabeledTree({"2781/objs/new-0.obj"}),
                    {"2782/objs/new-0.obj", "data_v0/2782/objs/new-0", "2782", "objs/new-1"}));
  CHECK(are_lacking(
      LabeledTree({"02691156/1a/models/model_normalized.obj"}),
      {"03001627/1a", "03001627/1a/models/model_normalized.obj", "02691156/2b/models/model_normalized.obj",
       "x/02691156/2b/models/model_normalized.obj", "shape_data/03001627/1a"}));
  // A folder of one synset as the input.
  const LabeledTree tree({"03001627/1a/models/model_normalized.obj"});
  tree.write("train.txt", "02691156/1a/models/model_normalized.obj\n");
  const std::string chairs = tree.in() + "/03001627";
  CHECK(collect_inputs({chairs}, tree.options({"train.txt"})).notes.lines_without_item == 1);
  tree.write("train.txt", "/mnt/set/03001627/1a/models/model_normalized.obj\n");
  CHECK(collect_inputs({chairs}, tree.options({"train.txt"})).notes.items_without_line == 0);
}

TEST_CASE("labels: JSON files of data sets are read") {
  const LabeledTree tree(
      {"03001627/aa/models/m.obj", "03001627/bb/models/m.obj", "02691156/cc/models/m.obj"});
  const auto lines = [&](const std::string& name, const std::string& text) {
    tree.write(name, text);
    Ids found;
    for (const std::string& line : tree.lines({name})) found.push_back(line.substr(line.find(' ') + 1));
    return found;
  };
  // Items are cc, aa, bb.
  CHECK(lines("shuffled_train_file_list.json", R"(["shape_data/03001627/aa", "shape_data/02691156/cc"])") ==
        Ids{"02691156 train", "03001627 train", "03001627 none"});
  CHECK(
      lines("model_info.json", R"([{"model_id": "aa", "super-category": "Chair", "category": "Lounge Chair"},
                                     {"model_id": "bb", "super-category": "Chair", "category": null}])") ==
      Ids{"02691156 none", "Lounge Chair none", "03001627 none"});
  CHECK(lines("Chair.val.json", R"([{"anno_id": "39446", "model_id": "bb"}])") ==
        Ids{"02691156 none", "03001627 none", "03001627 validation"});
  CHECK(lines("lvis-annotations.json", R"({"plane": ["cc"], "seat": ["aa", "bb"]})") ==
        Ids{"plane none", "seat none", "seat none"});
  CHECK(lines("splits.json", R"({"train": ["cc"], "test": ["aa"], "val": []})") ==
        Ids{"02691156 train", "03001627 test", "03001627 none"});
  CHECK(lines("sv2_chairs_test.json", R"({"ShapeNetV2": {"03001627": ["aa"], "02691156": ["cc"]}})") ==
        Ids{"02691156 test", "03001627 test", "03001627 none"});
  CHECK(lines("by_class.json", R"({"seat": {"train": ["aa"], "test": ["bb"]}})") ==
        Ids{"02691156 none", "seat train", "seat test"});
  CHECK(lines("by_id.json", R"({"aa": "train", "bb": "test"})") ==
        Ids{"02691156 none", "03001627 train", "03001627 test"});
  // As Objaverse and Hugging Face pack them, and in an archive.
  CHECK(lines("lvis.json.gz", gzip_bytes(R"({"plane": ["cc"]})"))[0] == "plane none");
  ArchiveEntry packed;
  packed.name = "lists/test.json";
  packed.content = R"(["aa"])";
  tree.write("lists.zip", zip_bytes({packed}));
  CHECK(tree.lines({"lists.zip/lists/test.json"})[1] == "03001627/aa/models/m.obj 03001627 test");
  CHECK_THAT(tree.refusal({"lists.zip/none.json"}), ContainsSubstring("there is no"));
  tree.write("cut.json.gz", gzip_bytes("[]").substr(0, 12));
  CHECK_THAT(tree.refusal({"cut.json.gz"}), ContainsSubstring("cannot unpack"));
  CHECK(lines("with_split.json", R"([{"uid": "aa", "split": "val", "label": "x"}])") ==
        Ids{"02691156 none", "x validation", "03001627 none"});
  const auto refusal = [&](const std::string& text) {
    tree.write("bad.json", text);
    return tree.refusal({"bad.json"});
  };
  CHECK_THAT(refusal(R"(["aa"])"), ContainsSubstring("this list of ids"));
  CHECK_THAT(refusal(R"({"aa": "chair"})"), ContainsSubstring("unknown form of JSON"));
  CHECK_THAT(refusal(R"({"a": {"b": {"c": {"d": {"e": []}}}}})"), ContainsSubstring("unknown form of JSON"));
  CHECK_THAT(refusal("7"), ContainsSubstring("unknown form of JSON"));
  CHECK_THAT(refusal(R"({"train": ["aa"], "extra": ["bb"]})"),
             ContainsSubstring("splits and other names") && ContainsSubstring("`extra`"));
  CHECK_THAT(refusal(R"([{"name": "aa"}])"), ContainsSubstring("entry 1 has no id"));
  CHECK_THAT(refusal(R"([{"id": "aa", "split": "later"}])"), ContainsSubstring("`later`"));
  CHECK_THAT(refusal(R"({"a": ["aa"], "b": ["aa"]})"),
             ContainsSubstring("entry 2: another class") && ContainsSubstring("entry 1"));
  CHECK_THAT(refusal("[1, 2"), ContainsSubstring("not valid JSON"));
  CHECK_THAT(refusal(std::string(1000, '[')), ContainsSubstring("nests deeper"));
}

TEST_CASE("labels: many ambiguous ids are resolved in little time", "[release]") {
  std::vector<std::string> ids;
  for (int i = 0; i < 20000; ++i)
    ids.push_back("x/" + std::to_string(100000 + i) + "/models/model_normalized.obj");
  ItemNames names;
  for (const std::string& id : ids) names.add(id, "/data/" + id);
  names.finish();
  std::size_t found = 0, other = 0, ambiguous = 0;
  for (int i = 0; i < 20000; ++i) {
    LabelLine line;
    line.names = {std::to_string(i) + "/models/model_normalized"};
    other += names.find(line).end;
    line.names = {"models/model_normalized.obj"};
    ambiguous += names.find(line).is_ambiguous;
    line.names = {std::to_string(100000 + i)};
    const ItemNames::Items items = names.find(line);
    found += items.end - items.begin == 1 && items.begin == static_cast<std::size_t>(i);
  }
  CHECK(other == 0);
  CHECK(ambiguous == 20000);
  CHECK(found == 20000);
}

TEST_CASE("folder layouts: auto makes no classes of other folders in the trees of data sets") {
  using enum FolderLayout;
  const auto layout = [](const Ids& ids) { return recognize_layout(ids); };
  CHECK(layout({"airplane/test/airplane_0627.off", "airplane/train/airplane_0001.off"}) == modelnet);
  CHECK(layout({"ModelNet10/bed/test/bed_0516.off", "ModelNet10/bed/train/bed_0001.off"}) == modelnet);
  CHECK(layout({"02691156/10155655850468db78d106ce0a280f87/models/model_normalized.obj"}) == shapenet);
  CHECK(layout({"ShapeNetCore.v1/02691156/10155655850468db78d106ce0a280f87/model.obj"}) == shapenet);
  CHECK(layout({"data_v0/2780/objs/new-0.obj", "data_v0/2780/objs/original-1.obj"}) == flat);
  CHECK(layout({"10213/textured_objs/original-1.obj"}) == flat);
  CHECK(layout({"00000002/00000002_1ffb81a71e5b402e966b9341_trimesh_001.obj"}) == flat);
  CHECK(layout({"32770.stl", "34783.stl"}) == flat);
  CHECK(layout({"glbs/000-023/8476c4170df24cf5bbe6967222d1a42d.glb"}) == flat);
  CHECK(layout({"scans/scene0000_00/scene0000_00_vh_clean_2.ply",
                "scans_test/scene0707_00/scene0707_00_vh_clean_2.ply"}) == flat);
  CHECK(layout({"3D-FUTURE-model/0a1b/normalized_model.obj", "3D-FUTURE-model/0a1b/raw_model.obj"}) == flat);
  CHECK(layout({"11pro_SL_TRX_FG/meshes/model.obj"}) == flat);
  CHECK(layout({"train/model_000003.obj", "test/model_000002.obj"}) == flat);
  // Folders of one model each are no classes.
  CHECK(layout({"test/0a1b/model.obj", "train/2c3d/model.obj", "train/4e5f/model.obj"}) == flat);
  CHECK(layout({"test/0a1b/normalized_model.obj", "test/0a1b/raw_model.obj",
                "train/2c3d/normalized_model.obj", "train/2c3d/raw_model.obj", "train/3d4e/raw_model.obj"}) ==
        flat);
  // Classes are, though their files have the same names, or no class is in both splits.
  CHECK(layout({"test/chair/1.off", "test/lamp/1.off", "train/chair/1.off", "train/lamp/1.off"}) == modelnet);
  CHECK(layout({"test/chair/1.off", "test/chair/2.off", "train/lamp/1.off", "train/lamp/2.off"}) == modelnet);
}
