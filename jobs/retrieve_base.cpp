#include "jobs/retrieve_base.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "jobs/classification.h"
#include "jobs/descriptor_choice.h"
#include "jobs/inputs.h"
#include "jobs/option_words.h"
#include "jobs/store_items.h"
#include "kernels/core/spelling.h"

namespace meander {

std::vector<DescriptorSchema> chosen_descriptors(const StoreReader& store, const std::string& wanted) {
  std::vector<DescriptorSchema> there, chosen;
  std::vector<std::string> names;
  std::string list;
  for (const DescriptorSchema& schema : store.descriptors()) {
    if (schema.group != "descriptors") continue;
    there.push_back(schema);
    names.push_back(schema.name);
    list += (list.empty() ? "" : ", ") + schema.name;
  }
  if (there.empty()) throw UsageError("the store has no descriptors to compare models by");
  if (wanted.empty()) return {there.front()};
  for (std::size_t begin = 0; begin <= wanted.size();) {
    const std::size_t end = std::min(wanted.find('+', begin), wanted.size());
    const std::string name = wanted.substr(begin, end - begin);
    const auto at = std::find(names.begin(), names.end(), name);
    if (at == names.end()) {
      const std::string near = nearest(name, names);
      throw UsageError(fmt::format("the store has no descriptor `{}`{}; it has {}", name,
                                   near.empty() ? "" : ", did you mean `" + near + "`?", list));
    }
    chosen.push_back(there[static_cast<std::size_t>(at - names.begin())]);
    begin = end + 1;
  }
  return chosen;
}

namespace {

// Bins of histograms have neighbours and one sum; separate values have neither.
void require_fitting(const DescriptorSchema& schema, DistanceKind distance) {
  if (is_histogram(schema) || (distance != DistanceKind::emd && distance != DistanceKind::chi2)) return;
  throw UsageError(
      fmt::format("the descriptor {} is a list of separate values, and {} compares the bins of histograms: "
                  "use l1, l2 or cosine",
                  schema.name, distance == DistanceKind::emd ? "emd" : "chi2"));
}

// Mean and standard deviation of every column; deviation 0 for a column of equal values.
std::vector<ColumnScale> column_scales(std::span<const float> values, std::size_t width) {
  std::vector<ColumnScale> scales(width);
  const std::size_t rows = values.size() / width;
  for (std::size_t column = 0; column < width; ++column) {
    double sum = 0, squares = 0;
    for (std::size_t row = 0; row < rows; ++row) sum += values[row * width + column];
    const double mean = sum / static_cast<double>(rows);
    for (std::size_t row = 0; row < rows; ++row) {
      const double offset = values[row * width + column] - mean;
      squares += offset * offset;
    }
    const double deviation = std::sqrt(squares / static_cast<double>(rows));
    // Rounding alone makes 1e-7 of the values.
    const bool constant = !(deviation > 1e-6 * std::abs(mean));
    scales[column] = {mean, constant ? 0 : deviation};
  }
  return scales;
}

// Every column to mean 0 and standard deviation 1; a column of equal values to 0.
void standardise(std::span<float> values, std::span<const ColumnScale> scales) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto& [mean, deviation] = scales[k % scales.size()];
    values[k] = deviation > 0 ? static_cast<float>((values[k] - mean) / deviation) : 0.0f;
  }
}

// Keeps the candidates that are ok and whose descriptors are finite, and builds the base of them.
RetrievalBase make_base(const StoreReader& store, const std::string& descriptor, DistanceKind distance,
                        const std::vector<std::uint64_t>& candidates,
                        const std::vector<std::uint32_t>& labels) {
  RetrievalBase result;
  result.schemas = chosen_descriptors(store, descriptor);
  const std::vector<DescriptorSchema>& schemas = result.schemas;
  std::vector<std::vector<float>> values;
  for (const DescriptorSchema& schema : schemas) {
    require_fitting(schema, distance);
    result.descriptors.push_back(schema.name);
    values.push_back(store.read_descriptor(schema.name));
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const std::uint64_t row = candidates[i];
    if (store.report(row).status != Status::ok) {
      ++result.not_ok;
      continue;
    }
    bool described = true;
    for (std::size_t d = 0; d < schemas.size(); ++d)
      described = described && is_described(schemas[d], std::span(values[d]).subspan(row * schemas[d].width,
                                                                                     schemas[d].width));
    if (!described) {
      ++result.not_finite;
      continue;
    }
    result.rows.push_back(row);
    if (!labels.empty()) result.labels.push_back(labels[i]);
  }
  if (result.rows.empty()) throw UsageError("no row of the store can be compared: none has its descriptors");
  std::vector<DescriptorBlock> blocks;
  for (std::size_t d = 0; d < schemas.size(); ++d) {
    const std::uint64_t width = schemas[d].width;
    std::vector<float> kept;
    kept.reserve(result.rows.size() * width);
    for (const std::uint64_t row : result.rows)
      kept.insert(kept.end(), values[d].begin() + static_cast<std::ptrdiff_t>(row * width),
                  values[d].begin() + static_cast<std::ptrdiff_t>((row + 1) * width));
    std::vector<ColumnScale>& scales = result.columns.emplace_back();
    if (!is_histogram(schemas[d])) {
      scales = column_scales(kept, width);
      standardise(kept, scales);
    }
    values[d] = std::move(kept);
    blocks.push_back({values[d], schemas[d].width});
  }
  result.base = make_descriptor_base(blocks, distance);
  return result;
}

// Rows by all that a .cla may call them.
class RowNames {
 public:
  explicit RowNames(const StoreReader& store) : store_(store) {
    for (std::uint64_t row = 0; row < store.rows(); ++row) {
      const std::string id = store.id(row);
      const std::filesystem::path path(id);
      std::unordered_set<std::string> names{id, path.filename().string(), path.stem().string()};
      for (const std::string& name : names) ++rows_.try_emplace(name, Entry{row, 0}).first->second.uses;
    }
  }
  std::optional<std::uint64_t> find(const std::string& model) const {
    for (const std::string& name : {model, "m" + model}) {
      if (const std::optional<std::uint64_t> row = store_.find(name))
        return row;  // whatever else is called so
      const auto at = rows_.find(name);
      if (at == rows_.end()) continue;
      if (at->second.uses > 1)
        throw UsageError(
            fmt::format("`{}` of the .cla may be any of {} items of the store", model, at->second.uses));
      return at->second.row;
    }
    return std::nullopt;
  }

 private:
  struct Entry {
    std::uint64_t row, uses;
  };
  const StoreReader& store_;
  std::unordered_map<std::string, Entry> rows_;
};

// Classes that psbTable leaves out by their name.
std::vector<std::uint32_t> miscellaneous(const std::vector<std::string>& classes) {
  std::vector<std::uint32_t> found;
  for (std::uint32_t c = 0; c < classes.size(); ++c)
    if (classes[c] == "miscellaneous" || classes[c] == "MISC_CLASS") found.push_back(c);
  return found;
}

}  // namespace

DistanceKind CompareOptions::kind() const { return value_of(distance_words, distance); }

void add_compare_options(Command& command, CompareOptions& options) {
  command.add_option("STORE", options.store, "The store").required();
  command.add_option("--descriptor", options.descriptor,
                     "Descriptor by its name in the store; several as a+b, each scaled by its mean distance "
                     "(default: the first of the store)");
  command.add_option("--distance", options.distance, "Distance between descriptors")
      .show_default()
      .one_of(all_words(distance_words));
  command.add_flag("--json", options.json, "Print the results as JSON");
  command.add_option("--csv", options.csv, "Also write the table to this CSV file");
  add_trust_option(command, options.check);
}

std::optional<DescriptorQuery> query_of(const RetrievalBase& base, std::span<const float> values) {
  std::vector<float> row(values.begin(), values.end());
  std::span<float> rest = row;
  for (std::size_t d = 0; d < base.schemas.size(); ++d) {
    const std::span<float> block = rest.first(base.schemas[d].width);
    if (!is_described(base.schemas[d], block)) return std::nullopt;
    if (!base.columns[d].empty()) standardise(block, base.columns[d]);
    rest = rest.subspan(block.size());
  }
  return make_descriptor_query(base.base, row);
}

RetrievalBase load_base(const StoreReader& store, const std::string& descriptor, DistanceKind distance) {
  std::vector<std::uint64_t> all;
  for (std::uint64_t row = 0; row < store.rows(); ++row) all.push_back(row);
  return make_base(store, descriptor, distance, all, {});
}

RetrievalBase load_labelled_base(const StoreReader& store, const std::string& descriptor,
                                 DistanceKind distance, const std::string& classification) {
  chosen_descriptors(store, descriptor);  // mistakes in names are reported before those in classes
  std::vector<std::uint64_t> rows;
  std::vector<std::uint32_t> labels;
  std::vector<std::string> classes;
  std::uint64_t not_in_store = 0;
  if (classification.empty()) {
    classes = store.label_names();
    for (std::uint64_t row = 0; row < store.rows(); ++row) {
      const std::int32_t label = store.label(row);
      if (label < 0 || static_cast<std::size_t>(label) >= classes.size()) continue;
      rows.push_back(row);
      labels.push_back(static_cast<std::uint32_t>(label));
    }
    if (rows.empty())
      throw UsageError(
          "no row of the store has a class: give --classes FILE.cla, or sample with --label-from-folder");
  } else {
    const Classification read = read_classification(classification);
    classes = read.classes;
    const RowNames names(store);
    std::unordered_set<std::uint64_t> taken;
    for (const Classification::Model& model : read.models) {
      const std::optional<std::uint64_t> row = names.find(model.name);
      if (!row) {
        ++not_in_store;
        continue;
      }
      if (!taken.insert(*row).second)
        throw UsageError(fmt::format("`{}` lists the model `{}` twice", classification, model.name));
      rows.push_back(*row);
      labels.push_back(model.label);
    }
    if (rows.empty()) throw UsageError("no model of `" + classification + "` is in the store");
  }
  RetrievalBase result = make_base(store, descriptor, distance, rows, labels);
  result.classes = std::move(classes);
  result.not_in_store = not_in_store;
  result.without_class = store.rows() - rows.size();
  return result;
}

RetrievalTask labelled_task(const RetrievalBase& base, bool psb_compat) {
  RetrievalTask task =
      make_retrieval_task(base.labels, base.classes.size(), psb_compat, miscellaneous(base.classes));
  if (std::count(task.scored.begin(), task.scored.end(), 1) == 0)
    throw UsageError(
        fmt::format("nothing can be scored: no class has {} models or more", psb_compat ? "three" : "two"));
  return task;
}

const char* rules_text(bool psb_compat) {
  return psb_compat
             ? "as psbTable: ties by row; classes of one or two models and the miscellaneous one are in no "
               "average"
             : "scores of ties are expected values under random order; classes of one model are not scored";
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : "+") + name;
  return text;
}

// "3 not ok, 1 without a class"; empty when every row is there.
std::string left_out_text(const RetrievalBase& base) {
  std::string text;
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, what);
  };
  add(base.not_ok, "not ok");
  add(base.not_finite, "without a usable descriptor");
  add(base.without_class, "without a class");
  add(base.not_in_store, "of the .cla that the store does not have");
  return text;
}

void write_left_out(JsonWriter& json, const RetrievalBase& base) {
  json.key("left_out");
  json.begin_object();
  json.member("not_ok", base.not_ok);
  json.member("not_finite", base.not_finite);
  json.member("without_class", base.without_class);
  json.member("not_in_store", base.not_in_store);
  json.end_object();
}

}  // namespace meander
