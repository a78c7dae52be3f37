#include "jobs/inputs/label_file.h"

#include <algorithm>
#include <cctype>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include "io/archive/model_bytes.h"
#include "io/file/file_error.h"
#include "io/file/read_file.h"
#include "io/json/json_tree.h"
#include "io/utf8.h"
#include "io/word_list.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/csv_text.h"
#include "jobs/inputs/folder_layout.h"

namespace meander {

namespace {

namespace fs = std::filesystem;

// Names of id columns, those that count first in front.
constexpr std::string_view id_names[] = {"id",       "uid",     "object_id", "anno_id",
                                         "model_id", "modelid", "file_id"};
constexpr std::string_view class_columns[] = {"class", "label", "category"};

// The split that the words of a file's name contain; Split::none for no split and for two.
Split split_of_file_name(const fs::path& path) {
  const std::string name = path.filename().string();
  Split found = Split::none;
  for (std::size_t at = 0; at < name.size();) {
    std::size_t end = at;
    while (end < name.size() && std::isalnum(static_cast<unsigned char>(name[end])) != 0) ++end;
    const Split split = split_of_word(std::string_view(name).substr(at, end - at));
    if (split != Split::none && found != Split::none && split != found) return Split::none;
    if (split != Split::none) found = split;
    at = end + 1;
  }
  return found;
}

struct LabelArgument {
  Split split = Split::none;
  std::string path;
};

LabelArgument understand(const std::string& argument) {
  const std::size_t equals = argument.find('=');
  if (equals == std::string::npos) return {Split::none, argument};
  const Split split = split_of_word(std::string_view(argument).substr(0, equals));
  if (split == Split::none) return {Split::none, argument};
  return {split, argument.substr(equals + 1)};
}

std::string gunzipped(const std::string& packed, const std::string& name) {
  const std::uint64_t most = std::max(most_free_bytes, packed.size() * most_unpacked_ratio);
  const MemorySource source(packed);
  try {
    const InflateSource unpacked(source, {0, packed.size()}, Wrapping::gzip, 0, most);
    std::string text, piece(std::size_t{1} << 18, '\0');
    for (std::size_t count = piece.size(); count == piece.size();) {
      count = unpacked.next(piece);
      text.append(piece, 0, count);
    }
    return text;
  } catch (const ItemError& error) {
    throw UsageError("--labels: cannot unpack `" + name + "`: " + error.what());
  }
}

// Reads each form of file into lines.
class LabelReader {
 public:
  LabelReader(LabelFile& file, Split given) : file_(file), given_(given) {
    by_name_ = split_of_file_name(file.name);
  }

  void read_table(std::string content) {
    CsvText text(std::move(content), "--labels: `" + file_.name + "`");
    std::vector<CsvRecord> records;
    bool is_list = true;
    while (auto record = text.next()) {
      if (record->is_blank()) continue;
      is_list = is_list && (record->fields.size() == 1 || record->is_comment());
      records.push_back(std::move(*record));
    }
    // A line of several fields that begins with # is a comment in a list, but an item in a table.
    std::erase_if(records, [&](const CsvRecord& record) {
      return record.is_comment() && (is_list || record.fields.size() == 1);
    });
    if (!is_list) return take_table(text, records);
    if (!take_category_names(records)) take_list(records);
  }

  void read_json(const std::string& content) {
    file_.is_json = true;
    const std::string_view text = without_byte_order_mark(content);
    try {
      const JsonTree tree(text);
      take_json(tree.root());
    } catch (const ItemError& error) {
      fail(error.what());
    }
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw UsageError("--labels: `" + file_.name + "`: " + what);
  }

  Split split_of_field(const std::string& word, std::uint64_t line) const {
    const Split split = split_of_word(word);
    LabelLine at;
    at.line = line;
    if (split == Split::none && !word.empty() && word != "none")
      throw UsageError("--labels: " + file_.place_of(at) + ": the split `" + word +
                       "` is not train, test or validation");
    return split;
  }

  void add(LabelLine line) {
    if (line.split == Split::none) line.split = given_;
    if (given_ != Split::none && line.split != given_)
      throw UsageError("--labels: " + file_.place_of(line) + ": the split is `" +
                       std::string(name_of(line.split)) + "`, but `" + std::string(name_of(given_)) +
                       "=` is given for the file");
    const auto [at, is_new] = first_lines_.emplace(line.names.front(), file_.lines.size());
    if (is_new) {
      file_.lines.push_back(std::move(line));
      return;
    }
    const LabelLine& first = file_.lines[at->second];
    if (first.label != line.label || first.split != line.split)
      throw UsageError("--labels: " + file_.place_of(line) + ": another class or split of `" + at->first +
                       "` than in " + (file_.is_json ? "entry " : "line ") + std::to_string(first.line));
  }

  // ---- Lists ----

  Split split_of_list() const {
    const Split split = given_ != Split::none ? given_ : by_name_;
    if (split == Split::none)
      fail(
          "this list of ids has no classes, and its name contains no split, or two: give the split, as in "
          "--labels train=" +
          file_.name);
    return split;
  }

  bool take_category_names(const std::vector<CsvRecord>& records) {
    std::map<std::string, std::string> names;
    for (const CsvRecord& record : records) {
      const std::string& field = record.fields[0];
      const std::size_t blank = field.find_last_of(" \t");
      if (blank == std::string::npos || !is_synset(std::string_view(field).substr(blank + 1))) return false;
      names[field.substr(blank + 1)] = field.substr(0, field.find_last_not_of(" \t", blank) + 1);
    }
    if (names.empty()) return false;
    refuse_split_of_names();
    file_.class_names = std::move(names);
    return true;
  }

  void refuse_split_of_names() const {
    if (given_ != Split::none) fail("a file of names of classes has no split: leave it out");
  }

  void take_list(const std::vector<CsvRecord>& records) {
    const bool headed = !records.empty() && std::count(std::begin(id_names), std::end(id_names),
                                                       lower_ascii(records[0].fields[0])) > 0;
    for (const CsvRecord& record : std::span(records).subspan(headed ? 1 : 0))
      add({{record.fields[0]}, {}, {}, split_of_list(), record.line});
  }

  // ---- Tables ----

  // The positions of the fields, and how many fields a line may have.
  struct Columns {
    std::vector<std::size_t> ids = {0};
    std::optional<std::size_t> label = 1, split = 2, synset, model;
    std::size_t min = 2, max = 3;
  };

  static std::optional<Columns> header_of(const CsvText& text, const CsvRecord& record) {
    const auto column = [&](std::string_view name) -> std::optional<std::size_t> {
      for (std::size_t i = 0; i < record.fields.size(); ++i)
        if (lower_ascii(record.fields[i]) == name) return i;
      return std::nullopt;
    };
    Columns columns;
    columns.ids.clear();
    for (const std::string_view name : id_names)
      if (const auto id = column(name)) columns.ids.push_back(*id);
    if (columns.ids.empty()) return std::nullopt;
    columns.label.reset();
    for (const std::string_view name : class_columns)
      if (!columns.label) columns.label = column(name);
    columns.split = column("split");
    columns.synset = column("synsetid");
    columns.model = column("modelid");
    if (columns.synset && columns.model && !columns.label) columns.label = columns.synset;
    if (!columns.label && !columns.split)
      text.fail(record.line,
                "the header has no column `class` (or `label`, `category`) and no column `split`");
    columns.min = columns.max = record.fields.size();
    return columns;
  }

  void take_table(const CsvText& text, const std::vector<CsvRecord>& records) {
    const auto headed = header_of(text, records[0]);
    const Columns columns = headed.value_or(Columns());
    const std::span<const CsvRecord> rows = std::span(records).subspan(headed ? 1 : 0);
    file_.is_shapenet = columns.synset && columns.model;
    for (const CsvRecord& record : rows) check_fields(text, record, columns);
    std::map<std::string_view, std::size_t> uses;  // of each model of an all.csv
    if (file_.is_shapenet)
      for (const CsvRecord& record : rows) ++uses[record.fields[*columns.model]];
    for (const CsvRecord& record : rows) {
      LabelLine line;
      line.line = record.line;
      if (columns.label) line.label = record.fields[*columns.label];
      if (columns.split && *columns.split < record.fields.size())
        line.split = split_of_field(record.fields[*columns.split], record.line);
      if (file_.is_shapenet)
        name_shapenet_model(record, columns, uses, line);
      else
        for (const std::size_t id : columns.ids)
          if (line.names.empty() || !record.fields[id].empty()) line.names.push_back(record.fields[id]);
      add(std::move(line));
    }
  }

  static void check_fields(const CsvText& text, const CsvRecord& record, const Columns& columns) {
    const std::size_t count = record.fields.size();
    if (count < columns.min || count > columns.max)
      text.fail(record.line,
                std::to_string(count) + " fields, must be " +
                    (columns.min == columns.max ? std::to_string(columns.max)
                                                : std::string("id, class and optionally split")));
  }

  static void name_shapenet_model(const CsvRecord& record, const Columns& columns,
                                  const std::map<std::string_view, std::size_t>& uses, LabelLine& line) {
    const std::string& model = record.fields[*columns.model];
    line.synset = record.fields[*columns.synset];
    line.names.push_back(line.synset + "/" + model);
    if (uses.at(model) == 1) line.names.push_back(model);
    if (!record.fields[columns.ids[0]].empty() && columns.ids[0] != *columns.model)
      line.names.push_back("model_" + record.fields[columns.ids[0]]);
  }

  // ---- JSON ----

  void take_json(JsonValue root) {
    const std::vector<JsonValue> items = root.items();
    const auto all = [&](auto is_right) { return std::all_of(items.begin(), items.end(), is_right); };
    const auto is_text = [](JsonValue value) { return value.text().has_value(); };
    const auto is_split = [](JsonValue value) {
      return value.text() && split_of_word(*value.text()) != Split::none;
    };
    if (root.is_array() && all(is_text)) {
      for (const JsonValue item : items) add_entry({std::string(*item.text())}, {}, Split::none);
    } else if (root.is_array() && all([](JsonValue item) { return bool(item.member("synsetId")); }) &&
               !items[0].member("modelId")) {
      name_synsets(items);
    } else if (root.is_array() && all([](JsonValue item) { return item.is_object(); })) {
      for (const JsonValue item : items) take_object(item);
    } else if (root.is_object() && all(is_split)) {
      for (const JsonValue item : items)
        add_entry({std::string(item.name())}, {}, split_of_word(*item.text()));
    } else if (root.is_object()) {
      take_lists(root, {}, Split::none, 0);
    } else {
      fail_form();
    }
  }

  [[noreturn]] void fail_form() const {
    fail(
        "unknown form of JSON: give a list of ids or of objects with an id, lists of ids by class or by "
        "split, splits by id, or taxonomy.json");
  }

  // Every entry has a class or a split.
  void add_entry(std::vector<std::string> names, std::string label, Split split) {
    ++entries_;
    if (split == Split::none && given_ == Split::none) split = label.empty() ? split_of_list() : by_name_;
    add({std::move(names), {}, std::move(label), split, entries_});
  }

  void take_object(JsonValue object) {
    ++entries_;
    LabelLine line;
    line.line = entries_;
    for (const JsonValue member : object.items()) {
      const std::string name = lower_ascii(member.name());
      const std::optional<std::string> text = text_of(member);
      if (!text) continue;
      if (name == "split") {
        line.split = split_of_field(*text, entries_);
      }
    }
    for (const std::string_view wanted : id_names)
      for (const JsonValue member : object.items())
        if (const auto text = text_of(member); text && lower_ascii(member.name()) == wanted)
          line.names.push_back(*text);
    for (const std::string_view wanted : class_columns)
      for (const JsonValue member : object.items())
        if (const auto text = text_of(member);
            text && line.label.empty() && lower_ascii(member.name()) == wanted)
          line.label = *text;
    if (line.names.empty()) fail("entry " + std::to_string(entries_) + " has no id");
    if (line.split == Split::none && given_ == Split::none) line.split = by_name_;
    const bool has_class = std::any_of(std::begin(class_columns), std::end(class_columns),
                                       [&](std::string_view name) { return bool(object.member(name)); });
    if (line.split == Split::none && given_ == Split::none && !has_class && !object.member("split"))
      split_of_list();
    add(std::move(line));
  }

  // The text of a string or of a whole number, which may be an id too.
  static std::optional<std::string> text_of(JsonValue value) {
    if (const auto text = value.text()) return std::string(*text);
    if (const auto count = value.count()) return std::to_string(*count);
    return std::nullopt;
  }

  // Takes lists of ids under names that are classes or splits.
  void take_lists(JsonValue object, const std::string& label, Split split, int depth) {
    constexpr int max_depth = 4;
    const std::vector<JsonValue> members = object.items();
    const auto is_split = [](JsonValue member) { return split_of_word(member.name()) != Split::none; };
    const auto splits = static_cast<std::size_t>(std::count_if(members.begin(), members.end(), is_split));
    if (splits != 0 && splits != members.size())
      fail("an object has both splits and other names (`" +
           std::string(std::find_if_not(members.begin(), members.end(), is_split)->name()) + "`)");
    for (const JsonValue member : members) {
      const std::string own_label = splits != 0 ? label : std::string(member.name());
      const Split own_split = splits != 0 ? split_of_word(member.name()) : split;
      if (member.is_object() && depth + 1 < max_depth) {
        take_lists(member, own_label, own_split, depth + 1);
        continue;
      }
      if (!member.is_array()) fail_form();
      for (const JsonValue item : member.items()) {
        const auto id = text_of(item);
        if (!id) fail_form();
        add_entry({*id}, own_label, own_split);
      }
    }
  }

  // Names each synset by its first name, "chair" of "chair,seat". If several synsets share it, the one that
  // is below no other keeps it, and the others get their number behind it ("cabinet 02933112").
  void name_synsets(const std::vector<JsonValue>& synsets) {
    refuse_split_of_names();
    std::map<std::string, bool> is_below;
    std::map<std::string, std::vector<std::string>> bearers;
    std::map<std::string, std::string> first_names;
    for (const JsonValue synset : synsets) {
      const auto number = text_of(synset.member("synsetId")), name = text_of(synset.member("name"));
      for (const JsonValue child : synset.member("children").items())
        if (const auto below = text_of(child)) is_below[*below] = true;
      if (!number || !name) fail("a synset has no number or no name");
      std::string first = name->substr(0, name->find(','));
      first.erase(first.find_last_not_of(' ') + 1);
      if (first.empty() || !first_names.emplace(*number, first).second) continue;
      bearers[first].push_back(*number);
    }
    for (const auto& [name, numbers] : bearers) {
      const auto is_top = [&](const std::string& number) { return !is_below.contains(number); };
      const auto tops = std::count_if(numbers.begin(), numbers.end(), is_top);
      for (const std::string& number : numbers) {
        const bool alone = numbers.size() == 1 || (tops == 1 && is_top(number));
        file_.class_names[number] = alone ? name : name + " " + number;
      }
    }
  }

  LabelFile& file_;
  Split given_, by_name_;
  std::map<std::string, std::size_t> first_lines_;  // by first name
  std::uint64_t entries_ = 0;                       // of JSON, so far
};

}  // namespace

std::string LabelFile::place_of(const LabelLine& line) const {
  return "`" + name + "` " + (is_json ? "entry " : "line ") + std::to_string(line.line);
}

fs::path path_of_labels(const std::string& argument) { return understand(argument).path; }

std::string content_of_labels(const fs::path& path) {
  std::string bytes;
  std::error_code error;
  try {
    if (!fs::exists(path, error) && !archive_in_path(path).empty()) {
      const PackedFile packed = find_packed(path);
      if (!packed) throw UsageError("--labels: there is no `" + path.string() + "` in the archive");
      bytes = packed.archive->unpack(packed.member);
    } else {
      bytes = content_of_file(path);
    }
  } catch (const FileError& failure) {
    throw UsageError("--labels: cannot read `" + path.string() + "`: " + failure.code().message());
  } catch (const ItemError& failure) {
    throw UsageError("--labels: cannot read `" + path.string() + "`: " + failure.what());
  }
  return bytes.starts_with("\x1F\x8B") ? gunzipped(bytes, path.string()) : bytes;
}

LabelFile read_label_file(const std::string& argument) {
  const LabelArgument given = understand(argument);
  LabelFile file;
  file.name = given.path;
  std::string content = content_of_labels(given.path);
  const std::string name = lower_ascii(given.path);
  LabelReader reader(file, given.split);
  if (name.ends_with(".json") || name.ends_with(".json.gz"))
    reader.read_json(content);
  else
    reader.read_table(std::move(content));
  return file;
}

LabelFile read_taxonomy(const std::string& text, const std::string& name) {
  LabelFile file;
  file.name = name;
  LabelReader(file, Split::none).read_json(text);
  if (!file.lines.empty() || file.class_names.empty())
    throw UsageError("--labels: `" + name + "` is not a taxonomy of ShapeNet");
  return file;
}

Classification read_classification(const std::filesystem::path& file) {
  std::istringstream in = [&] {
    try {
      return std::istringstream(std::string(without_byte_order_mark(content_of_file(file))));
    } catch (const FileError& error) {
      throw UsageError("cannot open `" + file.string() + "`: " + error.code().message());
    }
  }();
  std::string magic, version;
  std::uint64_t classes = 0, models = 0;
  if (!(in >> magic >> version >> classes >> models) || magic != "PSB")
    throw UsageError("`" + file.string() + "` is not a Princeton .cla file");
  Classification result;
  std::vector<std::string> parents;
  std::map<std::string, std::size_t> uses;
  for (std::uint64_t c = 0; c < classes; ++c) {
    std::string name, parent;
    std::uint64_t members = 0;
    if (!(in >> name >> parent >> members))
      throw UsageError("`" + file.string() + "` ends in class " + std::to_string(c + 1) + " of " +
                       std::to_string(classes));
    for (std::uint64_t m = 0; m < members; ++m) {
      std::string model;
      if (!(in >> model))
        throw UsageError("`" + file.string() + "`: class `" + name + "` ends before its " +
                         std::to_string(members) + " models");
      result.models.push_back({model, static_cast<std::uint32_t>(c)});
    }
    ++uses[name];
    result.classes.push_back(name);
    parents.push_back(parent);
  }
  for (std::size_t c = 0; c < result.classes.size(); ++c)
    if (uses[result.classes[c]] > 1) result.classes[c] = parents[c] + "/" + result.classes[c];
  if (result.models.size() != models)
    throw UsageError("`" + file.string() + "` promises " + std::to_string(models) + " models and lists " +
                     std::to_string(result.models.size()));
  return result;
}

}  // namespace meander
