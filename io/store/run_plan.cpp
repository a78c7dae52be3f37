#include "io/store/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/json_writer.h"
#include "io/parameters_text.h"
#include "io/store/crc32c.h"
#include "io/store/schema.h"
#include "io/store/store_file.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

// Raised with the format of journals, and with that of plans. Version 6 had the same journals. Shards of an
// array have none: version 5 of theirs was as 6.
constexpr std::string_view magic_begin = "meander plan ";
constexpr char plan_version = '7', sentence_version = '6', shard_version = '5';
constexpr std::size_t magic_bytes = magic_begin.size() + 2;  // with the version and a line feed

constexpr std::array<std::string_view, 6> purpose_phrases = {"sample",           "replace the store",
                                                             "update the store", "describe its rows",
                                                             "merge stores",     "sample surfaces"};
constexpr std::string_view retry_phrase = " with --retry ";

class PlanWriter {
 public:
  void number(std::uint64_t value) { text_.append(reinterpret_cast<const char*>(&value), sizeof value); }
  void text(std::string_view value) {
    number(value.size());
    text_ += value;
  }
  void texts(const std::vector<std::string>& values) {
    number(values.size());
    for (const std::string& value : values) text(value);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

// Reads what PlanWriter wrote. The checksum has been checked, but it says nothing of who wrote it: every
// number is checked before it is used.
class PlanReader {
 public:
  PlanReader(std::string_view text, const fs::path& path) : text_(text), path_(path) {}
  std::uint64_t number() {
    std::uint64_t value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  // At most `most`.
  std::uint64_t number(std::uint64_t most) {
    const std::uint64_t value = number();
    if (value > most) damaged();
    return value;
  }
  // Of elements that have at least so many bytes each.
  std::size_t count(std::size_t bytes_each) { return number(text_.size() / bytes_each); }
  void end() const {
    if (!text_.empty()) damaged();
  }
  std::string text() { return std::string(take(number())); }
  [[noreturn]] void damaged() const {
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is damaged: start anew with --fresh", path_.string()));
  }
  std::vector<std::string> texts() {
    std::vector<std::string> values;
    for (std::uint64_t left = number(); left > 0; --left) values.push_back(text());
    return values;
  }

 private:
  std::string_view take(std::uint64_t count) {
    if (count > text_.size()) damaged();
    const std::string_view taken = text_.substr(0, count);
    text_.remove_prefix(count);
    return taken;
  }
  std::string_view text_;
  const fs::path& path_;
};

std::vector<std::string> names_in(const ColumnSet& set) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < sample_columns.size(); ++c)
    if (set[c]) names.emplace_back(sample_columns[c].name);
  return names;
}

std::string plan_text(const RunPlan& run) {
  const StoreHeader& header = run.header;
  PlanWriter plan;
  plan.number(store_format_version);
  plan.number(header.method_version);
  plan.number(static_cast<std::uint64_t>(run.purpose));
  plan.text(run.retry);
  plan.text(run.root);
  const StoreColumns& columns = *header.columns;
  plan.number(static_cast<std::uint64_t>(columns.rows));
  plan.number(columns.tensors);
  for (const ColumnSet* const set : {&columns.asked, &columns.left_out}) plan.texts(names_in(*set));
  plan.number(columns.attributes.size());
  for (const AttributeColumn& column : columns.attributes) {
    plan.text(column.name);
    plan.number(column.width);
    plan.number(static_cast<std::uint64_t>(column.kind));
  }
  plan.number(header.samples);
  plan.number(static_cast<std::uint64_t>(header.compression));
  plan.number(header.seed);
  plan.text(header.order);
  plan.text(header.parameters_json);
  plan.texts(header.label_names);
  plan.number(header.descriptors.size());
  for (const DescriptorSchema& descriptor : header.descriptors) {
    plan.text(descriptor.group);
    plan.text(descriptor.name);
    plan.number(descriptor.width);
    plan.number(descriptor.attributes.size());
    for (const auto& [name, value] : descriptor.attributes) {
      plan.text(name);
      plan.text(value);
    }
  }
  plan.texts(header.ids);
  for (const std::int32_t label : header.labels) plan.number(static_cast<std::uint32_t>(label));
  for (std::uint64_t row = 0; row < header.ids.size(); ++row)
    plan.number(static_cast<std::uint64_t>(header.split(row)));
  return plan.take();
}

struct StoredPlan {
  std::uint64_t format_version = 0;
  RunPlan run;
};

ColumnSet parse_set(PlanReader& plan) {
  ColumnSet set;
  for (const std::string& name : plan.texts()) {
    const auto at = std::find_if(sample_columns.begin(), sample_columns.end(),
                                 [&](const SampleColumn& column) { return column.name == name; });
    if (at == sample_columns.end()) plan.damaged();
    set[static_cast<std::size_t>(at - sample_columns.begin())] = true;
  }
  return set;
}

// As version 6 wrote the sets, by numbers.
void parse_numbered_sets(PlanReader& plan, StoreColumns& columns) {
  constexpr std::array<std::string_view, 8> words = {"normals", "face",       "corners", "barycentric",
                                                     "uv",      "curve_rank", "density", "tensor"};
  columns.asked[&Samples::rgb] = plan.number(1) != 0;
  columns.asked[&Samples::texcoord] = plan.number(1) != 0;
  const std::uint64_t left_out = plan.number((1u << words.size()) - 1);
  for (std::size_t c = 0; c < sample_columns.size(); ++c)
    for (std::size_t w = 0; w < words.size(); ++w)
      if (sample_columns[c].word() == words[w]) columns.left_out[c] = (left_out >> w & 1) != 0;
}

// As version 6 wrote it, by a phrase.
void parse_purpose_phrase(PlanReader& plan, RunPlan& run) {
  std::string phrase = plan.text();
  if (const std::size_t at = phrase.find(retry_phrase); at != std::string::npos) {
    run.retry = phrase.substr(at + retry_phrase.size());
    phrase.resize(at);
  }
  const auto at = std::find(purpose_phrases.begin(), purpose_phrases.end(), phrase);
  if (at == purpose_phrases.end()) plan.damaged();
  run.purpose = static_cast<RunPurpose>(at - purpose_phrases.begin());
}

StoredColumns parse_columns(PlanReader& plan, bool is_numbered) {
  StoreColumns columns;
  columns.rows = static_cast<RowKind>(plan.number(static_cast<std::uint64_t>(RowKind::surfaces)));
  columns.tensors = plan.number(1) != 0;
  if (is_numbered) {
    parse_numbered_sets(plan, columns);
  } else {
    columns.asked = parse_set(plan);
    columns.left_out = parse_set(plan);
  }
  if (columns.rows == RowKind::surfaces && (columns.tensors || columns.asked[&Samples::rgb])) plan.damaged();
  columns.attributes.resize(plan.number(most_chosen_columns));
  for (AttributeColumn& column : columns.attributes) {
    column.name = plan.text();
    column.width = static_cast<std::uint32_t>(plan.number(4));
    column.kind = static_cast<AttributeKind>(plan.number(static_cast<std::uint64_t>(AttributeKind::classes)));
  }
  try {
    return StoredColumns(std::move(columns));
  } catch (const ItemError&) {
    plan.damaged();
  }
}

StoredPlan parse_plan(std::string_view text, bool is_earlier, const fs::path& path) {
  constexpr std::uint64_t most32 = std::numeric_limits<std::uint32_t>::max();
  PlanReader plan(text, path);
  StoredPlan stored;
  StoreHeader& header = stored.run.header;
  stored.format_version = plan.number();
  if (stored.format_version != store_format_version) return stored;  // the rest may be laid out otherwise
  header.method_version = static_cast<std::uint32_t>(plan.number(most32));
  if (is_earlier) {
    parse_purpose_phrase(plan, stored.run);
  } else {
    stored.run.purpose = static_cast<RunPurpose>(plan.number(purpose_phrases.size() - 1));
    stored.run.retry = plan.text();
  }
  stored.run.root = plan.text();
  header.columns = parse_columns(plan, is_earlier);
  header.samples = static_cast<std::uint32_t>(plan.number(most32));
  header.compression = static_cast<Compression>(plan.number(static_cast<std::uint64_t>(Compression::none)));
  header.seed = plan.number();
  header.order = plan.text();
  header.parameters_json = plan.text();
  header.label_names = plan.texts();
  header.descriptors.resize(plan.count(4 * sizeof(std::uint64_t)));
  for (DescriptorSchema& descriptor : header.descriptors) {
    descriptor.group = plan.text();
    descriptor.name = plan.text();
    descriptor.width = static_cast<std::uint32_t>(plan.number(most32));
    descriptor.attributes.resize(plan.count(2 * sizeof(std::uint64_t)));
    for (auto& [name, value] : descriptor.attributes) {
      name = plan.text();
      value = plan.text();
    }
  }
  header.ids = plan.texts();
  header.labels.resize(header.ids.size());
  for (std::int32_t& label : header.labels)
    label = static_cast<std::int32_t>(static_cast<std::uint32_t>(plan.number(most32)));
  for (std::size_t row = 0; row < header.ids.size(); ++row)
    header.splits.push_back(static_cast<Split>(plan.number(split_names.size() - 1)));
  plan.end();
  return stored;
}

std::string run_json(const RunPlan& run, std::string_view plan) {
  const StoreHeader& header = run.header;
  JsonWriter json;
  json.begin_object();
  json.member("tool", "meander");
  json.member("tool_version", tool_version());
  json.member("format_version", store_format_version);
  json.member("method_version", header.method_version);
  json.member("purpose", purpose_text(run));
  json.member("rows", std::uint64_t{header.ids.size()});
  json.member("samples", header.samples);
  json.member("seed", header.seed);
  json.member("order", header.order);
  json.member("compression", header.compression == Compression::standard ? "standard" : "none");
  json.member("plan_sha256", hex_text(sha256(std::as_bytes(std::span(plan)))));
  std::string text = json.text();
  // The parameters are JSON already.
  if (!header.parameters_json.empty()) text += ",\"parameters\":" + header.parameters_json;
  return text + "}\n";
}

// Both lists ascend by bytes.
std::string id_difference(const std::vector<std::string>& begun, const std::vector<std::string>& now) {
  std::vector<std::string> removed, added;
  std::set_difference(begun.begin(), begun.end(), now.begin(), now.end(), std::back_inserter(removed));
  std::set_difference(now.begin(), now.end(), begun.begin(), begun.end(), std::back_inserter(added));
  if (removed.empty() && added.empty()) return {};
  std::string text = "the items differ:";
  if (!removed.empty())
    text += fmt::format(" {} gone (the first is \"{}\")", removed.size(), removed.front());
  if (!removed.empty() && !added.empty()) text += ",";
  if (!added.empty()) text += fmt::format(" {} new (the first is \"{}\")", added.size(), added.front());
  return text;
}

std::string descriptor_difference(const std::vector<DescriptorSchema>& begun,
                                  const std::vector<DescriptorSchema>& now) {
  const auto names = [](const std::vector<DescriptorSchema>& descriptors) {
    std::string text;
    for (const DescriptorSchema& descriptor : descriptors)
      text += fmt::format("{}{}({})", text.empty() ? "" : ", ", descriptor.name, descriptor.width);
    return text.empty() ? std::string("none") : text;
  };
  if (names(begun) != names(now))
    return fmt::format("the descriptors were {}, now they are {}", names(begun), names(now));
  for (std::size_t i = 0; i < begun.size(); ++i)
    if (begun[i].attributes != now[i].attributes)
      return fmt::format("the bins of descriptor {} differ", begun[i].name);
  return {};
}

std::string_view name_of(Compression compression) {
  return compression == Compression::standard ? "default" : "none";
}

}  // namespace

std::string first_difference(const RunPlan& begun_plan, const RunPlan& now_plan) {
  const StoreHeader &begun = begun_plan.header, &now = now_plan.header;
  if (begun_plan.purpose != now_plan.purpose || begun_plan.retry != now_plan.retry)
    return fmt::format("it was begun to {}, not to {}", purpose_text(begun_plan), purpose_text(now_plan));
  if (begun_plan.root != now_plan.root)
    return fmt::format("the ids of lists were relative to {}, now they are to {}", begun_plan.root,
                       now_plan.root);
  if (begun.method_version != now.method_version)
    return fmt::format("the method version was {}, now it is {}", begun.method_version, now.method_version);
  if (begun.columns->rows != now.columns->rows) return "one is of meshes, the other of parametric surfaces";
  // All that a command can set is here, and all of it is named.
  if (const std::string text = parameter_differences(begun.parameters_json, now.parameters_json);
      !text.empty())
    return text;
  if (!(begun.columns == now.columns))
    return fmt::format("the columns were {}, now they are {}", fmt::join(column_list(begun.columns), ", "),
                       fmt::join(column_list(now.columns), ", "));
  if (begun.samples != now.samples)
    return fmt::format("the number of samples was {}, now it is {}", begun.samples, now.samples);
  if (begun.seed != now.seed) return fmt::format("the seed was {}, now it is {}", begun.seed, now.seed);
  if (begun.compression != now.compression)
    return fmt::format("the compression was {}, now it is {}", name_of(begun.compression),
                       name_of(now.compression));
  if (begun.order != now.order) return fmt::format("the order was {}, now it is {}", begun.order, now.order);
  if (const std::string text = descriptor_difference(begun.descriptors, now.descriptors); !text.empty())
    return text;
  if (const std::string text = id_difference(begun.ids, now.ids); !text.empty()) return text;
  if (begun.label_names != now.label_names)
    return fmt::format("the names of the classes differ ({} then, {} now)", begun.label_names.size(),
                       now.label_names.size());
  for (std::size_t row = 0; row < begun.labels.size(); ++row)
    if (begun.labels[row] != now.labels[row])
      return fmt::format("the label of \"{}\" was {}, now it is {}", begun.ids[row], begun.labels[row],
                         now.labels[row]);
  for (std::size_t row = 0; row < begun.ids.size(); ++row)
    if (begun.split(row) != now.split(row))
      return fmt::format("the split of \"{}\" was {}, now it is {}", begun.ids[row],
                         meander::name_of(begun.split(row)), meander::name_of(now.split(row)));
  return {};
}

bool plan_exists(const fs::path& run_folder) { return fs::exists(run_folder / "run.json"); }

void write_plan(const fs::path& run_folder, const RunPlan& plan) {
  std::string text = fmt::format("{}{}\n", magic_begin, plan_version);
  text += plan_text(plan);
  const std::uint32_t checksum = crc32c(std::span<const char>(text));
  text.append(reinterpret_cast<const char*>(&checksum), sizeof checksum);
  replace_file(run_folder / "plan.bin", text, FullDisk::stops_run);
  replace_file(run_folder / "run.json", run_json(plan, text), FullDisk::stops_run);
}

namespace {

[[noreturn]] void refuse(const fs::path& run_folder, const std::string& why) {
  throw RunError(RunError::Kind::unusable,
                 fmt::format("{} was begun with other inputs or parameters and cannot be continued: {} "
                             "(repeat the command that began it, or start anew with --fresh)",
                             run_folder.string(), why));
}

}  // namespace

namespace {

RunPlan read_plan(const fs::path& run_folder, bool is_of_shard) {
  const fs::path path = run_folder / "plan.bin";
  const std::optional<std::string> text = content_if_exists(path);
  std::uint32_t checksum = 0;
  if (text && text->size() > sizeof checksum)
    std::memcpy(&checksum, text->data() + text->size() - sizeof checksum, sizeof checksum);
  if (!text || text->size() < magic_bytes + sizeof checksum ||
      checksum != crc32c(std::span<const char>(text->data(), text->size() - sizeof checksum)))
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is damaged: start anew with --fresh", path.string()));
  std::string_view plan(*text);
  plan.remove_suffix(sizeof checksum);
  const char version =
      plan.starts_with(magic_begin) && plan[magic_bytes - 1] == '\n' ? plan[magic_bytes - 2] : 0;
  if (version != plan_version && version != sentence_version && !(is_of_shard && version == shard_version))
    throw RunError(
        RunError::Kind::unusable,
        fmt::format("{} was begun by another version of the program and cannot be continued: finish "
                    "it with that version, or start anew with --fresh",
                    run_folder.string()));
  plan.remove_prefix(magic_bytes);
  StoredPlan stored = parse_plan(plan, version != plan_version, path);
  if (stored.format_version != store_format_version)
    refuse(run_folder,
           fmt::format("the store format was {}, now it is {}", stored.format_version, store_format_version));
  return std::move(stored.run);
}

}  // namespace

RunPlan read_plan(const fs::path& run_folder) { return read_plan(run_folder, false); }

RunPlan read_plan_of_shard(const fs::path& folder) { return read_plan(folder, true); }

void require_same_plan(const fs::path& run_folder, const RunPlan& plan) {
  const RunPlan begun = read_plan(run_folder);
  if (plan_text(begun) != plan_text(plan)) refuse(run_folder, first_difference(begun, plan));
}

}  // namespace meander::store

namespace meander {

std::string purpose_text(const RunPlan& plan) {
  std::string text(store::purpose_phrases[static_cast<std::size_t>(plan.purpose)]);
  return plan.retry.empty() ? text : text.append(store::retry_phrase) + plan.retry;
}

}  // namespace meander
