#include "jobs/rows/retrieve_base.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "jobs/cli/option_words.h"
#include "jobs/cli/units.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/label_file.h"
#include "jobs/inputs/store_items.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/foreign_vectors.h"
#include "jobs/rows/graph_file.h"
#include "jobs/rows/local_codes.h"
#include "jobs/rows/rank_option.h"

namespace meander {

std::string misfit(const DescriptorSchema& schema, DistanceKind distance) {
  const bool emd = distance == DistanceKind::emd;
  if (!emd && distance != DistanceKind::chi2) return {};
  if (!is_histogram(schema))
    return fmt::format(
        "the descriptor {} is a list of separate values, and {} compares the bins of histograms: use l1, l2 "
        "or "
        "cosine",
        schema.name, emd ? "emd" : "chi2");
  if (emd && !has_bins_in_line(schema))
    return fmt::format(
        "the values of {} are not bins along one line, and emd measures along a line of bins: use l1, "
        "l2, "
        "chi2 or cosine",
        schema.name);
  return {};
}

namespace {

constexpr std::uint64_t program_bytes = std::uint64_t{48} << 20;  // with its libraries
constexpr std::uint64_t mebibyte = std::uint64_t{1} << 20;

void require_memory(std::uint64_t needed, std::uint64_t memory, const std::string& what) {
  if (needed > memory)
    throw UsageError(fmt::format("--memory: {} needs about {}M", what, (needed + mebibyte - 1) / mebibyte));
}

// Sums over the rows of a column, whose mean comes first.
std::vector<ColumnScale> scales_of_columns(std::span<const double> sums, std::span<const double> squares,
                                           std::uint64_t rows) {
  std::vector<ColumnScale> scales(sums.size());
  for (std::size_t column = 0; column < sums.size(); ++column) {
    const double mean = sums[column] / static_cast<double>(rows);
    const double deviation = std::sqrt(squares[column] / static_cast<double>(rows));
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

// Row `row` of the store becomes row `at` of a part of the base.
void set_row(const RetrievalBase& base, DescriptorBase& part, std::size_t at, const DescribedBlock& block,
             std::uint64_t row, std::vector<float>& scratch) {
  for (std::size_t t = 0; t < base.terms.size(); ++t) {
    const std::span<const float> values = block.values(t, row);
    if (base.columns[t].empty()) {
      set_descriptor_row(part, t, at, values);
      continue;
    }
    scratch.assign(values.begin(), values.end());
    standardise(scratch, base.columns[t]);
    set_descriptor_row(part, t, at, scratch);
  }
}

constexpr std::uint8_t wanted_row = 1, described_row = 2;

// Marks the wanted rows that have the descriptors, and counts the others.
void mark_described(const StoreReader& store, std::span<const DescriptorTerm> terms,
                    std::vector<std::uint8_t>& rows, RetrievalBase& base) {
  visit_described(store, terms, 0, [&](const DescribedBlock& block) {
    for (std::uint64_t row = block.first(); row < block.first() + block.count(); ++row) {
      if (rows[row] != wanted_row) continue;
      if (block.is_described(row))
        rows[row] = described_row;
      else
        ++(store.report(row).status == Status::ok ? base.not_finite : base.not_ok);
    }
  });
}

void require_rows(bool any) {
  if (!any) throw UsageError("no row of the store can be compared: none has its descriptors");
}

// Means first, then deviations, as two passes over the separate values.
void find_column_scales(const StoreReader& store, const std::vector<std::uint8_t>& rows,
                        RetrievalBase& base) {
  base.columns.resize(base.terms.size());
  for (std::size_t t = 0; t < base.terms.size(); ++t) {
    if (is_histogram(base.terms[t].schema)) continue;
    const std::size_t width = base.terms[t].schema.width;
    std::vector<double> sums(width, 0), squares(width, 0);
    std::uint64_t count = 0;
    const auto visit = [&](const auto& add) {
      visit_described(store, std::span(base.terms).subspan(t, 1), 0, [&](const DescribedBlock& block) {
        for (std::uint64_t row = block.first(); row < block.first() + block.count(); ++row)
          if (rows[row] == described_row) add(block.values(0, row));
      });
    };
    visit([&](std::span<const float> values) {
      ++count;
      for (std::size_t k = 0; k < width; ++k) sums[k] += values[k];
    });
    visit([&](std::span<const float> values) {
      for (std::size_t k = 0; k < width; ++k) {
        const double offset = values[k] - sums[k] / static_cast<double>(count);
        squares[k] += offset * offset;
      }
    });
    base.columns[t] = scales_of_columns(sums, squares, count);
  }
}

// Descriptors and layout, without rows.
RetrievalBase layout_of(const StoreReader& store, const BaseRequest& request) {
  RetrievalBase base;
  base.terms = chosen_descriptors(store, request.descriptor, request.side);
  std::vector<DescriptorBlock> blocks;
  for (const DescriptorTerm& term : base.terms) {
    if (const std::string why = misfit(term.schema, request.distance); !why.empty()) throw UsageError(why);
    // Codes are of length 1, and their likeness is the inner product.
    const bool is_code = term.side && term.side->local;
    blocks.push_back({{}, term.schema.width, term.weight});
    if (is_code && request.distance == DistanceKind::l1) blocks.back().kind = DistanceKind::cosine;
  }
  base.base = empty_descriptor_base(blocks, request.distance);
  return base;
}

std::uint64_t row_bytes(const DescriptorBase& base) {
  std::uint64_t bytes = 0;
  for (const DescriptorBase::Block& block : base.blocks) bytes += sizeof(float) * std::uint64_t{block.stride};
  return bytes;
}

// The scales of blocks whose rows are not in memory: those of the pairs are read.
void find_scales(const StoreReader& store, std::span<const std::uint64_t> rows, RetrievalBase& base,
                 std::uint64_t memory) {
  if (base.terms.size() < 2) return;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs = scale_pairs(rows.size());
  std::vector<std::uint32_t> needed;
  for (const auto& [i, j] : pairs) needed.insert(needed.end(), {i, j});
  std::sort(needed.begin(), needed.end());
  needed.erase(std::unique(needed.begin(), needed.end()), needed.end());
  require_memory(program_bytes + needed.size() * row_bytes(base.base) +
                     2 * described_block_rows * described_row_bytes(base.terms),
                 memory, "scaling descriptors by their mean distances");
  DescriptorBase few = base.base;
  resize_descriptor_base(few, needed.size());
  std::size_t at = 0;
  std::vector<float> scratch;
  visit_described(store, base.terms, 0, [&](const DescribedBlock& block) {
    for (; at < needed.size() && rows[needed[at]] < block.first() + block.count(); ++at)
      set_row(base, few, at, block, rows[needed[at]], scratch);
  });
  const auto place = [&](std::uint32_t row) {
    return static_cast<std::uint32_t>(std::lower_bound(needed.begin(), needed.end(), row) - needed.begin());
  };
  for (auto& [i, j] : pairs) i = place(i), j = place(j);
  set_descriptor_scales(few, pairs);
  for (std::size_t t = 0; t < base.terms.size(); ++t) base.base.blocks[t].scale = few.blocks[t].scale;
}

// The ranking of STORE.graph where it fits, or a new one.
RowRanking ranking_of(const RetrievalBase& base, const BaseRequest& request) {
  if (request.rank.kind == RankKind::diffusion && !request.graph_of.empty()) {
    const std::filesystem::path path = graph_path(request.graph_of);
    if (const auto read = read_graph(path, origin_of_graph(request.graph_of, base, request))) return *read;
    if (base.rows.size() > max_ranked_rows && std::filesystem::exists(path))
      throw UsageError(fmt::format(
          "`{}` is the graph of other rows, descriptors or settings: `meander retrieve graph` makes "
          "it anew; --rank plain or scaled needs none",
          path.string()));
  }
  return make_row_ranking(base.base, request.rank);
}

// The candidates that have their descriptors, in their order, in memory.
RetrievalBase make_base(const StoreReader& store, const BaseRequest& request,
                        const std::vector<std::uint64_t>& candidates,
                        const std::vector<std::uint32_t>& labels) {
  RetrievalBase result = layout_of(store, request);
  std::vector<DescriptorTerm> needed = result.terms;
  if (!request.also_described.empty()) {
    const std::vector<DescriptorTerm> more = chosen_descriptors(store, request.also_described, request.side);
    needed.insert(needed.end(), more.begin(), more.end());
  }
  std::vector<std::uint8_t> rows(store.rows(), 0);
  for (const std::uint64_t row : candidates) rows[row] = wanted_row;
  mark_described(store, needed, rows, result);
  std::vector<std::uint32_t> place(store.rows(), 0);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (rows[candidates[i]] != described_row) continue;
    place[candidates[i]] = static_cast<std::uint32_t>(result.rows.size());
    result.rows.push_back(candidates[i]);
    result.labels.push_back(labels[i]);
  }
  require_rows(!result.rows.empty());
  // Distances in blocks and the scores of every row, besides the values.
  constexpr std::uint64_t distance_bytes = 72 * mebibyte, scores_bytes = 400;
  require_memory(program_bytes + distance_bytes + request.held +
                     result.rows.size() * (row_bytes(result.base) + scores_bytes) +
                     row_ranking_bytes(request.rank, result.rows.size()) +
                     2 * described_block_rows * described_row_bytes(result.terms),
                 request.memory, fmt::format("a comparison of {} models", result.rows.size()));
  find_column_scales(store, rows, result);
  resize_descriptor_base(result.base, result.rows.size());
  std::vector<float> scratch;
  visit_described(store, result.terms, 0, [&](const DescribedBlock& block) {
    for (std::uint64_t row = block.first(); row < block.first() + block.count(); ++row)
      if (rows[row] == described_row) set_row(result, result.base, place[row], block, row, scratch);
  });
  if (result.terms.size() > 1) set_descriptor_scales(result.base, scale_pairs(result.rows.size()));
  result.ranking = ranking_of(result, request);
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

void add_comparison_options(Command& command, CompareOptions& options) {
  command.add_option("STORE", options.store, "The store").required();
  command
      .add_option(
          "--descriptor", options.descriptor,
          "Descriptor by its name in the store; several as a+b, each scaled by its mean distance, "
          "or with weights as a=2+b (default: pairs, views and local-pairs, as far as they are there, or "
          "else the first)")
      .common();
  command.add_option("--distance", options.distance, "Distance between descriptors")
      .show_default()
      .common()
      .one_of(all_words(distance_words));
  add_rank_option(command, options.rank);
  command.add_option("--vectors", options.vectors,
                     "Vectors of another program as a descriptor, called like this .npy file: rows x values");
  command.add_option(
      "--ids", options.ids,
      "The ids of the rows of --vectors: a line each, or a CSV table with a column id (default: "
      "the rows of the store in their order)");
  command.add_option("--memory", options.memory, "Limit of the memory of the whole process")
      .show_default()
      .bytes();
  add_trust_option(command, options.check);
}

void add_compare_options(Command& command, CompareOptions& options) {
  add_comparison_options(command, options);
  command.add_flag("--json", options.json, "Print the results as JSON").common();
  command.add_option("--csv", options.csv, "Also write the table to this CSV file");
}

namespace {

// The descriptors that find most together, of those that are there.
std::string recommended_descriptors(const StoreReader& store, const std::string& path) {
  const auto has = [&](std::string_view name) {
    return std::any_of(store.descriptors().begin(), store.descriptors().end(),
                       [&](const DescriptorSchema& schema) { return schema.name == name; });
  };
  std::vector<NamedTerm> terms;
  for (const Descriptor descriptor : {Descriptor::pairs, Descriptor::pairs_unsigned, Descriptor::views}) {
    const std::string name(name_of(descriptor));
    const bool second = descriptor == Descriptor::pairs_unsigned && !terms.empty();
    if (has(name) && !second) terms.push_back({name});
  }
  if (std::filesystem::exists(words_path(path))) terms.push_back({local_pairs_name});
  return joined(terms);
}

}  // namespace

BaseRequest request_of(const StoreReader& store, const CompareOptions& options) {
  BaseRequest request{.descriptor = options.descriptor,
                      .distance = options.kind(),
                      .memory = parse_bytes(options.memory),
                      .graph_of = options.store};
  bool recommended = false;
  if (!options.vectors.empty()) {
    request.side.push_back(read_foreign_vectors(store, options.vectors, options.ids));
    if (request.descriptor.empty()) request.descriptor = foreign_name(options.vectors);
  } else if (!options.ids.empty()) {
    throw UsageError("--ids names the rows of --vectors: give both, or neither");
  }
  if (request.descriptor.empty() && request.distance != DistanceKind::emd) {
    request.descriptor = recommended_descriptors(store, options.store);
    recommended = !request.descriptor.empty();
  }
  for (std::shared_ptr<const SideVectors>& vectors :
       named_side_vectors(store, options.store, request.descriptor))
    request.side.push_back(std::move(vectors));
  if (!options.rank.empty())
    request.rank = parse_rank(options.rank);
  else if (recommended &&
           (store.rows() <= max_ranked_rows || std::filesystem::exists(graph_path(options.store))))
    request.rank.kind = RankKind::diffusion;
  for (const std::shared_ptr<const SideVectors>& vectors : request.side)
    request.held += vectors->values.size() * sizeof(float);
  return request;
}

std::optional<DescriptorQuery> query_of(const RetrievalBase& base, std::span<const float> values) {
  std::vector<float> row(values.begin(), values.end());
  std::span<float> rest = row;
  for (std::size_t t = 0; t < base.terms.size(); ++t) {
    const std::span<float> block = rest.first(base.terms[t].schema.width);
    if (!is_described(base.terms[t].schema, block)) return std::nullopt;
    if (!base.columns[t].empty()) standardise(block, base.columns[t]);
    rest = rest.subspan(block.size());
  }
  return make_descriptor_query(base.base, row);
}

std::optional<DescriptorQuery> query_of(const StoreReader& store, const RetrievalBase& base,
                                        std::uint64_t row) {
  std::vector<float> values;
  for (const DescriptorTerm& term : base.terms) {
    const std::vector<float> part = term.read(store, row, 1);
    values.insert(values.end(), part.begin(), part.end());
  }
  return query_of(base, values);
}

RetrievalBase load_searched_base(const StoreReader& store, const BaseRequest& request) {
  RetrievalBase result = layout_of(store, request);
  result.columns.resize(result.terms.size());
  const bool scaled = result.terms.size() > 1 || !is_histogram(result.terms[0].schema);
  if (!scaled) return result;  // nothing depends on the other rows
  std::vector<std::uint8_t> rows(store.rows(), wanted_row);
  RetrievalBase counted;  // again when they are searched
  mark_described(store, result.terms, rows, counted);
  std::vector<std::uint64_t> described;
  for (std::uint64_t row = 0; row < rows.size(); ++row)
    if (rows[row] == described_row) described.push_back(row);
  require_rows(!described.empty());
  find_column_scales(store, rows, result);
  find_scales(store, described, result, request.memory);
  return result;
}

void search_store(const StoreReader& store, RetrievalBase& base, NearestSearch& search, std::uint64_t memory,
                  std::uint64_t held) {
  // Two blocks as they are read, one laid out, and distances to 256 queries.
  const std::uint64_t a_row = 2 * described_row_bytes(base.terms) + row_bytes(base.base) +
                              256 * sizeof(float) + sizeof(std::uint32_t);
  const std::uint64_t fixed = program_bytes + held + store.rows() * sizeof(std::uint64_t);
  constexpr std::uint64_t least = 256;
  require_memory(fixed + least * a_row, memory, fmt::format("a search of {} rows", store.rows()));
  const std::uint64_t at_once =
      std::clamp((memory - fixed) / a_row / least * least, least, described_block_rows);
  DescriptorBase part = base.base;
  std::vector<std::uint32_t> numbers;
  std::vector<float> scratch;
  visit_described(store, base.terms, at_once, [&](const DescribedBlock& block) {
    numbers.clear();
    for (std::uint64_t row = block.first(); row < block.first() + block.count(); ++row) {
      if (block.is_described(row))
        numbers.push_back(static_cast<std::uint32_t>(row));
      else
        ++(store.report(row).status == Status::ok ? base.not_finite : base.not_ok);
    }
    resize_descriptor_base(part, numbers.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) set_row(base, part, i, block, numbers[i], scratch);
    search.search(part, numbers);
    base.rows.insert(base.rows.end(), numbers.begin(), numbers.end());
  });
  require_rows(!base.rows.empty());
}

RetrievalBase load_labeled_base(const StoreReader& store, const BaseRequest& request,
                                const std::string& classification) {
  layout_of(store, request);  // mistakes in names are reported before those in classes
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
  RetrievalBase result = make_base(store, request, rows, labels);
  result.classes = std::move(classes);
  result.not_in_store = not_in_store;
  result.without_class = store.rows() - rows.size();
  return result;
}

RetrievalBase load_ranked_base(const StoreReader& store, const BaseRequest& request) {
  std::vector<std::uint64_t> rows(store.rows());
  std::iota(rows.begin(), rows.end(), std::uint64_t{0});
  return make_base(store, request, rows, std::vector<std::uint32_t>(rows.size(), 0));
}

RetrievalTask labeled_task(const RetrievalBase& base, bool psb_compat) {
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
