#include "io/store/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstring>
#include <limits>
#include <span>
#include <type_traits>
#include <utility>

#include "io/digest.h"
#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/json_writer.h"
#include "io/parameters_text.h"
#include "io/store/crc32c.h"
#include "io/store/run_folder.h"
#include "io/store/schema.h"
#include "io/store/store_file.h"
#include "kernels/core/joined_texts.h"

namespace meander::store {

namespace fs = std::filesystem;

namespace {

// Raised with the format of journals, and with that of plans. Version 6 had the same journals. Shards of an
// array have none: version 5 of theirs was as 6.
constexpr std::string_view magic_begin = "meander plan ";
constexpr char plan_version = '7', sentence_version = '6', shard_version = '5';
// The oldest store format whose plans are laid out as today's, and whose journals hold the same columns.
constexpr std::uint32_t oldest_planned_format = 5;
constexpr std::size_t magic_bytes = magic_begin.size() + 2;  // with the version and a line feed

constexpr std::array<std::string_view, 6> purpose_phrases = {"sample",           "replace the store",
                                                             "update the store", "describe its rows",
                                                             "merge stores",     "sample surfaces"};
constexpr std::string_view retry_phrase = " with --retry ";

std::uint64_t last_number(RowKind) { return static_cast<std::uint64_t>(RowKind::surfaces); }
std::uint64_t last_number(RunPurpose) { return purpose_phrases.size() - 1; }
std::uint64_t last_number(AttributeKind) { return static_cast<std::uint64_t>(AttributeKind::classes); }
std::uint64_t last_number(Compression) { return static_cast<std::uint64_t>(Compression::none); }
std::uint64_t last_number(Split) { return split_names.size() - 1; }

class PlanWriter {
 public:
  template <std::integral Number>
  void number(const Number& value) {
    const std::uint64_t wide = static_cast<std::make_unsigned_t<Number>>(value);
    text_.append(reinterpret_cast<const char*>(&wide), sizeof wide);
  }
  template <class Choice>
  void choice(const Choice& value) {
    number(static_cast<std::uint64_t>(value));
  }
  void truth(const bool& value) { number(std::uint64_t{value}); }
  void text(std::string_view value) {
    number(value.size());
    text_ += value;
  }
  // Each of which takes `least_bytes` or more.
  template <class Values, class One>
  void list(const Values& values, std::size_t, const One& one) {
    number(values.size());
    for (const auto& value : values) one(value);
  }
  void purpose(const RunPlan& run) {
    choice(run.purpose);
    text(run.retry);
  }
  void sets(const StoreColumns& columns) {
    for (const ColumnSet* const set : {&columns.asked, &columns.left_out}) {
      number(set->count([](const SampleColumn&) { return true; }));
      for (std::size_t c = 0; c < sample_columns.size(); ++c)
        if ((*set)[c]) text(sample_columns[c].name);
    }
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

// Reads what PlanWriter wrote, or version 6. The checksum has been checked, but it says nothing of who wrote
// it: every number is checked before it is used.
class PlanReader {
 public:
  PlanReader(std::string_view text, bool is_earlier, const fs::path& path)
      : text_(text), is_earlier_(is_earlier), path_(path) {}
  template <std::integral Number>
  void number(Number& value) {
    value = static_cast<Number>(read(std::numeric_limits<std::make_unsigned_t<Number>>::max()));
  }
  template <class Choice>
  void choice(Choice& value) {
    value = static_cast<Choice>(read(last_number(value)));
  }
  void truth(bool& value) { value = read(1) != 0; }
  void text(std::string& value) { value = take(read()); }
  template <class Values, class One>
  void list(Values& values, std::size_t least_bytes, const One& one) {
    values.resize(read(text_.size() / least_bytes));
    for (auto& value : values) one(value);
  }
  void purpose(RunPlan& run) {
    if (is_earlier_) return earlier_purpose(run);
    choice(run.purpose);
    text(run.retry);
  }
  void sets(StoreColumns& columns) {
    if (is_earlier_) return earlier_sets(columns);
    for (ColumnSet* const set : {&columns.asked, &columns.left_out})
      for (std::uint64_t left = read(sample_columns.size()); left > 0; --left) {
        const std::string_view name = take(read());
        const auto is_named = [&](const SampleColumn& column) {
          return column.name == name || column.name_in(oldest_planned_format) == name;
        };
        std::size_t c = 0;
        while (c < sample_columns.size() && !is_named(sample_columns[c])) ++c;
        if (c == sample_columns.size()) damaged();
        (*set)[c] = true;
      }
  }
  bool at_end() const { return text_.empty(); }
  void end() const {
    if (!text_.empty()) damaged();
  }
  [[noreturn]] void damaged() const {
    throw RunError(RunError::Kind::unusable,
                   fmt::format("{} is damaged: start anew with --fresh", path_.string()));
  }

 private:
  std::uint64_t read(std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) {
    std::uint64_t value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    if (value > most) damaged();
    return value;
  }
  std::string_view take(std::uint64_t count) {
    if (count > text_.size()) damaged();
    const std::string_view taken = text_.substr(0, count);
    text_.remove_prefix(count);
    return taken;
  }
  // A phrase.
  void earlier_purpose(RunPlan& run) {
    std::string_view phrase = take(read());
    if (const std::size_t at = phrase.find(retry_phrase); at != phrase.npos) {
      run.retry = phrase.substr(at + retry_phrase.size());
      phrase = phrase.substr(0, at);
    }
    const auto at = std::find(purpose_phrases.begin(), purpose_phrases.end(), phrase);
    if (at == purpose_phrases.end()) damaged();
    run.purpose = static_cast<RunPurpose>(at - purpose_phrases.begin());
  }
  // Numbers.
  void earlier_sets(StoreColumns& columns) {
    constexpr std::array<std::string_view, 8> words = {"normals", "face",       "corners", "barycentric",
                                                       "uv",      "curve_rank", "density", "tensor"};
    truth(columns.asked[&Samples::rgb]);
    truth(columns.asked[&Samples::texcoord]);
    const std::uint64_t left_out = read((1u << words.size()) - 1);
    for (std::size_t c = 0; c < sample_columns.size(); ++c)
      for (std::size_t w = 0; w < words.size(); ++w)
        if (sample_columns[c].recorded_word() == words[w]) columns.left_out[c] = (left_out >> w & 1) != 0;
  }

  std::string_view text_;
  bool is_earlier_;
  const fs::path& path_;
};

// What a plan has behind the format version, in its order, written or read.
template <class Plan, class Run>
void exchange(Plan& plan, Run& run, auto& columns) {
  constexpr std::size_t number_bytes = 8;  // of a number, and of an empty text
  const auto text = [&](auto& value) { plan.text(value); };
  auto& header = run.header;
  plan.number(header.method_version);
  plan.purpose(run);
  plan.text(run.root);
  plan.choice(columns.rows);
  plan.truth(columns.tensors);
  plan.sets(columns);
  plan.list(columns.attributes, 3 * number_bytes, [&](auto& column) {
    plan.text(column.name);
    plan.number(column.width);
    plan.choice(column.kind);
  });
  plan.number(header.samples);
  plan.choice(header.compression);
  plan.number(header.seed);
  plan.text(header.order);
  plan.text(header.parameters_json);
  plan.list(header.label_names, number_bytes, text);
  plan.list(header.descriptors, 4 * number_bytes, [&](auto& descriptor) {
    plan.text(descriptor.group);
    plan.text(descriptor.name);
    plan.number(descriptor.width);
    plan.list(descriptor.attributes, 2 * number_bytes, [&](auto& attribute) {
      plan.text(attribute.first);
      plan.text(attribute.second);
    });
  });
  plan.list(header.ids, number_bytes, text);
}

// The sets of points beside the samples.
template <class Plan>
void exchange_sets(Plan& plan, auto& columns) {
  for (auto& count : columns.counts) plan.number(count);
  plan.truth(columns.sides);
  plan.truth(columns.nearest);
  plan.truth(columns.halves);
  plan.list(columns.query_groups, sizeof(std::uint64_t), [&](auto& name) { plan.text(name); });
}

std::string plan_text(const RunPlan& run) {
  PlanWriter plan;
  plan.number(store_format_version);
  exchange(plan, run, *run.header.columns);
  for (const std::int32_t label : run.header.labels) plan.number(label);
  for (std::uint64_t row = 0; row < run.header.ids.size(); ++row) plan.choice(run.header.split(row));
  // Plans of rows without further sets end here, as they did before there were any.
  if (run.header.columns->has_sets()) exchange_sets(plan, *run.header.columns);
  return plan.take();
}

bool is_planned(std::uint32_t format_version) {
  return format_version >= oldest_planned_format && format_version <= store_format_version;
}

struct StoredPlan {
  std::uint32_t format_version = 0;
  RunPlan run;
};

StoredPlan parse_plan(std::string_view text, bool is_earlier, const fs::path& path) {
  PlanReader plan(text, is_earlier, path);
  StoredPlan stored;
  StoreHeader& header = stored.run.header;
  plan.number(stored.format_version);
  if (!is_planned(stored.format_version)) return stored;  // the rest may be laid out otherwise
  StoreColumns columns;
  exchange(plan, stored.run, columns);
  header.labels.resize(header.ids.size());
  for (std::int32_t& label : header.labels) plan.number(label);
  header.splits.resize(header.ids.size());
  for (Split& split : header.splits) plan.choice(split);
  if (!plan.at_end()) exchange_sets(plan, columns);
  plan.end();
  if (columns.rows == RowKind::surfaces && (columns.tensors || columns.asked[&Samples::rgb])) plan.damaged();
  try {
    header.columns = StoredColumns(std::move(columns));
  } catch (const ItemError&) {
    plan.damaged();
  }
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
    return fmt::format("the columns were {}, now they are {}", joined_texts(column_list(begun.columns)),
                       joined_texts(column_list(now.columns)));
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
  if (!is_planned(stored.format_version))
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

std::optional<RunPlan> read_run_plan(const std::filesystem::path& store) {
  const std::filesystem::path folder = store::with_suffix(store, ".run");
  if (!store::plan_exists(folder)) return std::nullopt;
  return store::read_plan(folder);
}

std::string purpose_text(const RunPlan& plan) {
  std::string text(store::purpose_phrases[static_cast<std::size_t>(plan.purpose)]);
  return plan.retry.empty() ? text : text.append(store::retry_phrase) + plan.retry;
}

}  // namespace meander
