#include "jobs/export/export_descriptors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <limits>
#include <optional>
#include <string_view>

#include "io/file/atomic_file.h"
#include "io/store/ann_file_writer.h"
#include "io/table/npy_header.h"
#include "jobs/cli/command_line.h"
#include "jobs/cli/exit_status.h"
#include "jobs/cli/usage_error.h"
#include "jobs/cli/working_process.h"
#include "jobs/export/export_format.h"
#include "jobs/rows/descriptor_choice.h"
#include "jobs/rows/local_codes.h"
#include "jobs/rows/retrieve_base.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/parallel.h"
#include "kernels/retrieve/descriptor_distance.h"

namespace meander {

namespace {

// The described rows of a store, as one table that is read in blocks.
class DescribedRows {
 public:
  DescribedRows(const StoreReader& store, const DescriptorExport& options)
      : store_(store),
        side_(named_side_vectors(store, options.store, options.descriptors)),
        terms_(chosen_descriptors(store, options.descriptors, side_)),
        wanted_(options.rows) {
    std::sort(wanted_.begin(), wanted_.end());
    wanted_.erase(std::unique(wanted_.begin(), wanted_.end()), wanted_.end());
    for (const DescriptorTerm& term : terms_) width_ += term.schema.width;
    if (std::any_of(terms_.begin(), terms_.end(), [](const DescriptorTerm& t) { return t.weight != 1; }))
      factors_ = weight_factors();
    visit_blocks([&](std::span<const std::uint64_t> rows, std::span<const float>) {
      rows_.insert(rows_.end(), rows.begin(), rows.end());
    });
    if (rows_.empty()) throw UsageError("no row of the store has these descriptors");
    left_out_ = (wanted_.empty() ? store.rows() : wanted_.size()) - rows_.size();
  }

  std::uint32_t width() const { return width_; }
  const std::vector<std::uint64_t>& rows() const { return rows_; }
  std::uint64_t left_out() const { return left_out_; }
  bool is_weighted() const { return !factors_.empty(); }

  // Names of the values: b0, b1, ... or the names that the descriptor gives; with several of them in front.
  std::vector<std::string> columns() const {
    std::vector<std::string> names;
    for (const DescriptorTerm& term : terms_) {
      const DescriptorSchema& schema = term.schema;
      const std::string prefix = terms_.size() > 1 ? schema.name + "_" : "";
      std::string given;
      for (const auto& [name, text] : schema.attributes)
        if (name == columns_attribute) given = text;
      for (std::uint32_t b = 0; b < schema.width; ++b) {
        const std::string name = given.substr(0, given.find(','));
        given.erase(0, std::min(given.size(), name.size() + 1));
        names.push_back(prefix + (name.empty() ? fmt::format("b{}", b) : name));
      }
    }
    return names;
  }

  // Calls visit(rows of the store, their values row by row) for blocks of rows, ascending.
  using Visit = std::function<void(std::span<const std::uint64_t>, std::span<const float>)>;
  void visit_blocks(const Visit& visit) const {
    visit_described(store_, terms_, 0, [&](const DescribedBlock& block) {
      std::vector<std::uint64_t> rows;
      std::vector<float> values;
      for (std::uint64_t row = block.first(); row < block.first() + block.count(); ++row) {
        if (!block.is_described(row) ||
            !(wanted_.empty() || std::binary_search(wanted_.begin(), wanted_.end(), row)))
          continue;
        rows.push_back(row);
        for (std::size_t t = 0; t < terms_.size(); ++t)
          for (const float value : block.values(t, row))
            values.push_back(factors_.empty() ? value : factors_[t] * value);
      }
      visit(rows, values);
    });
  }

 private:
  // What makes l1 between the vectors of the file the combined distance of `retrieve`.
  std::vector<float> weight_factors() const {
    const RetrievalBase scaled = load_searched_base(store_, {.descriptor = joined(terms_), .side = side_});
    std::vector<float> factors;
    for (std::size_t t = 0; t < terms_.size(); ++t) {
      if (terms_[t].side)
        throw UsageError(fmt::format("{} is compared by cosine, and weights are for l1: no weights",
                                     terms_[t].schema.name));
      if (!is_histogram(terms_[t].schema))
        throw UsageError(
            fmt::format("{} holds separate values, which an export leaves as they are: no weights",
                        terms_[t].schema.name));
      factors.push_back(static_cast<float>(terms_[t].weight / scaled.base.blocks[t].scale));
    }
    return factors;
  }

  const StoreReader& store_;
  const SideVectorsList side_;
  const std::vector<DescriptorTerm> terms_;
  std::vector<float> factors_;  // of the terms, where they have weights
  std::vector<std::uint64_t> wanted_, rows_;
  std::uint32_t width_ = 0;
  std::uint64_t left_out_ = 0;
};

// RFC 4180.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string label_of(const StoreReader& store, std::uint64_t row) {
  const std::int32_t label = store.label(row);
  return label < 0 ? "" : csv_cell(store.label_names().at(static_cast<std::size_t>(label)));
}

void write_csv(const StoreReader& store, const DescribedRows& table,
               const std::function<void(std::string_view)>& put) {
  put(fmt::format("id,label,{}\n", joined_texts(table.columns(), ",")));
  table.visit_blocks([&](std::span<const std::uint64_t> rows, std::span<const float> values) {
    std::string text;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      text += csv_cell(store.id(rows[i])) + "," + label_of(store, rows[i]);
      for (const float value : values.subspan(i * table.width(), table.width()))
        text += fmt::format(",{}", value);
      text += "\n";
    }
    put(text);
  });
}

void write_csv_file(const StoreReader& store, const DescribedRows& table, const std::string& path) {
  AtomicFile file(path);
  write_csv(store, table, [&file](std::string_view text) { file.append(text); });
  file.commit();
}

std::string ids_path(const std::string& path) { return path + ".ids.csv"; }

// Where the rows of the file come from. `test`: one entry per row where there is a split, else empty.
void write_ids(const StoreReader& store, const DescribedRows& table, const std::vector<std::uint8_t>& test,
               AtomicFile& file) {
  file.append(test.empty() ? "position,row,id,label\n" : "part,position,row,id,label\n");
  for (const std::uint8_t part : {std::uint8_t{0}, std::uint8_t{1}}) {
    std::uint64_t position = 0;
    std::string text;
    for (std::size_t i = 0; i < table.rows().size(); ++i) {
      if ((test.empty() ? 0 : test[i]) != part) continue;
      const std::uint64_t row = table.rows()[i];
      if (!test.empty()) text += part == 0 ? "train," : "test,";
      text += fmt::format("{},{},{},{}\n", position++, row, csv_cell(store.id(row)), label_of(store, row));
    }
    file.append(text);
  }
}

std::string fbin_header(const DescribedRows& table) {
  if (table.rows().size() > std::numeric_limits<std::uint32_t>::max())
    throw UsageError("fbin holds at most 2^32 - 1 rows");
  const std::uint32_t header[2] = {static_cast<std::uint32_t>(table.rows().size()), table.width()};
  return {reinterpret_cast<const char*>(header), sizeof header};
}

// The header, then all values row by row, little-endian; and the list of the rows.
void write_values(const StoreReader& store, const DescribedRows& table, const std::string& header,
                  const std::string& path) {
  AtomicFile file(path), ids(ids_path(path));
  file.append(header);
  table.visit_blocks([&](std::span<const std::uint64_t>, std::span<const float> values) {
    file.append(std::as_bytes(values));
  });
  write_ids(store, table, {}, ids);
  file.commit();
  ids.commit();
}

// ---- ANN-benchmarks ---------------------------------------------------------------------------------------

// Queries spread evenly over the rows, which are in the order of the ids: every folder gives its share.
std::vector<std::uint8_t> split(std::size_t rows, std::size_t queries) {
  std::vector<std::uint8_t> test(rows, 0);
  for (std::size_t q = 0; q < queries; ++q) test[(2 * q + 1) * rows / (2 * queries)] = 1;
  return test;
}

// A base that grows block by block, so that its vectors are in memory once.
class GrowingBase {
 public:
  GrowingBase(DistanceKind kind, std::uint32_t width, std::size_t rows)
      : kind_(kind), width_(width), room_(rows) {}

  void append(std::span<const float> values) {
    if (values.empty()) return;
    const DescriptorBlock block{values, width_};
    DescriptorBase more = make_descriptor_base(std::span(&block, 1), kind_);
    if (base_.blocks.empty()) {
      base_ = std::move(more);
      base_.blocks[0].values.reserve(room_ * base_.blocks[0].stride);
      return;
    }
    std::vector<float>& all = base_.blocks[0].values;
    all.insert(all.end(), more.blocks[0].values.begin(), more.blocks[0].values.end());
    base_.rows += more.rows;
  }
  const DescriptorBase& base() const { return base_; }

 private:
  const DistanceKind kind_;
  const std::uint32_t width_;
  const std::size_t room_;
  DescriptorBase base_;
};

void write_ann(const StoreReader& store, const DescribedRows& table, const DescriptorExport& options) {
  const std::size_t rows = table.rows().size();
  const std::size_t queries =
      options.queries > 0 ? static_cast<std::size_t>(options.queries)
                          : std::max<std::size_t>(
                                1, static_cast<std::size_t>(options.test_share * static_cast<double>(rows)));
  if (queries >= rows)
    throw UsageError(fmt::format("{} queries of {} rows leave none to search", queries, rows));
  const std::size_t train = rows - queries;
  if (options.wants_neighbors && options.neighbors > train)
    throw UsageError(fmt::format("--neighbors: there are {} rows to search", train));
  const std::size_t count = std::min<std::size_t>(options.neighbors, train);
  const DistanceKind kind = options.distance == "l2" ? DistanceKind::l2 : DistanceKind::cosine;
  const std::vector<std::uint8_t> test = split(rows, queries);

  AnnFileWriter file(options.output, {train, queries, table.width(), static_cast<std::uint32_t>(count)},
                     kind == DistanceKind::l2 ? "euclidean" : "angular");
  AtomicFile ids(ids_path(options.output));
  GrowingBase all(kind, table.width(), rows);
  std::vector<float> test_values;
  std::size_t at = 0;
  table.visit_blocks([&](std::span<const std::uint64_t> block, std::span<const float> values) {
    std::vector<float> train_values;
    for (std::size_t i = 0; i < block.size(); ++i) {
      const auto row = values.subspan(i * table.width(), table.width());
      std::vector<float>& to = test[at++] ? test_values : train_values;
      to.insert(to.end(), row.begin(), row.end());
    }
    file.append_train(train_values);
    all.append(train_values);
  });
  file.append_test(test_values);
  all.append(test_values);

  constexpr std::size_t block = 256;
  for (std::size_t begin = 0; begin < queries; begin += block) {
    const std::size_t here = std::min(block, queries - begin);
    std::vector<std::int32_t> positions(here * count);
    std::vector<float> distances(here * count);
    parallel_tasks(here, [&](std::size_t q) {
      std::vector<float> to(train);
      descriptor_distances(all.base(), train + begin + q, 0, to);
      std::vector<std::int32_t> order(train);
      for (std::size_t i = 0; i < train; ++i) order[i] = static_cast<std::int32_t>(i);
      const auto nearer = [&](std::int32_t a, std::int32_t b) {
        const float to_a = to[static_cast<std::size_t>(a)], to_b = to[static_cast<std::size_t>(b)];
        return to_a != to_b ? to_a < to_b : a < b;
      };
      std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count), order.end(),
                        nearer);
      for (std::size_t k = 0; k < count; ++k) {
        positions[q * count + k] = order[k];
        distances[q * count + k] = to[static_cast<std::size_t>(order[k])];
      }
    });
    file.append_neighbors(positions, distances);
  }
  write_ids(store, table, test, ids);
  file.finish();
  ids.commit();
}

}  // namespace

void add_descriptor_export_options(const Command& whole, DescriptorExport& options) {
  const auto given = [&options] { options.shapes_split = true; };
  Command command = whole.under("Descriptors");
  command
      .add_option("--descriptors", options.descriptors,
                  "Write these descriptors with --format " + formats_with(ExportContent::descriptors, "or") +
                      ": NAME, several as NAME+NAME, or with weights as NAME=2+NAME for distances l1; also "
                      "local-pairs, the codes of `retrieve words`")
      .common();
  const Option share =
      command.add_option("--test-share", options.test_share, "ann-hdf5: share of the rows that are queries")
          .show_default()
          .range(1e-9, 0.999999)
          .on_given(given);
  command.add_option("--queries", options.queries, "ann-hdf5: number of rows that are queries")
      .range(std::uint64_t{1}, std::uint64_t{1000000000})
      .on_given(given)
      .excludes(share);
  command
      .add_option("--neighbors", options.neighbors,
                  "ann-hdf5: exact neighbors per query (at most the number of rows searched)")
      .show_default()
      .range(1, 1000000)
      .on_given([&options] { options.shapes_split = options.wants_neighbors = true; });
  command.add_option("--distance", options.distance, "ann-hdf5: l2 (euclidean) or cosine (angular)")
      .show_default()
      .one_of({"l2", "cosine"})
      .on_given(given);
}

void check_descriptor_export(const DescriptorExport& options, const std::string& format,
                             const std::string& output) {
  if (export_format(format).content == ExportContent::descriptors) {
    if (options.descriptors.empty())
      throw UsageError("--format " + format + " holds descriptors: name them with --descriptors");
    if (output.empty()) throw UsageError("export of descriptors needs -o FILE");
    if (output == standard_output && format != "csv")
      throw UsageError("--format " + format + " is more than one file: -o FILE, or --format csv with -o -");
  } else if (!options.descriptors.empty()) {
    throw UsageError("--descriptors needs --format " + formats_with(ExportContent::descriptors, "or"));
  }
  if (options.shapes_split && format != "ann-hdf5")
    throw UsageError("--test-share, --queries, --neighbors and --distance apply to --format ann-hdf5 only");
}

int export_descriptors(const StoreReader& store, const DescriptorExport& options, OutputGuard& guard) {
  if (options.output == standard_output) {
    write_csv(store, DescribedRows(store, options), print_bytes);
    return exit_done;
  }
  const FileKind kind = export_format(options.format).kind;
  guard.check(options.output, {kind}, "-o", options.existing);
  if (kind != FileKind::csv)
    guard.check(ids_path(options.output), {FileKind::csv}, "the list of rows of -o", options.existing);
  const DescribedRows table(store, options);
  if (options.format == "ann-hdf5" && table.is_weighted())
    throw UsageError("--descriptors: weights scale l1 between the vectors, and ann-hdf5 is for l2 or cosine");
  if (options.format == "csv") {
    write_csv_file(store, table, options.output);
  } else if (options.format == "fbin") {
    write_values(store, table, fbin_header(table), options.output);
  } else if (options.format == "npy") {
    const std::array<std::uint64_t, 2> shape = {table.rows().size(), table.width()};
    write_values(store, table, npy_header("<f4", shape), options.output);
  } else {
    write_ann(store, table, options);
  }
  fmt::print("{} rows of {} values in {}", table.rows().size(), table.width(), options.output);
  if (table.left_out() > 0) fmt::print("; {} rows without these descriptors left out", table.left_out());
  fmt::print("\n");
  return exit_done;
}

}  // namespace meander
