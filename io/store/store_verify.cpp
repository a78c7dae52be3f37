#include "io/store/store_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <optional>

#include "io/json/json_tree.h"
#include "io/parameters_text.h"
#include "io/store/chunk_codec.h"
#include "io/store/crc32c.h"
#include "io/store/item_block.h"
#include "io/store/row_ranges.h"
#include "io/store/store_file.h"
#include "io/store/store_reader.h"
#include "kernels/core/half.h"
#include "kernels/core/parallel.h"

namespace meander {

using namespace store;

namespace {

// Checks of one row. Rows are checked in parallel; each writes to a list of its own.
class RowChecker {
 public:
  RowChecker(std::string name, const ItemReport& report, const StoredColumns& columns,
             std::vector<std::string>& problems)
      : name_(std::move(name)), report_(report), columns_(columns), problems_(problems) {}

  // topology: the run looked for it (see parameters of runs).
  void check_items(bool topology) {
    const std::size_t bits = columns_->chosen_count();
    if (bits < most_chosen_columns && report_.lacks >> bits != 0)
      complain("{} lacks columns that the store does not have: {:#x}", name_, report_.lacks);
    if ((report_.missing & ~report_.lacks) != 0)
      complain("{} is missing columns that it does not lack: {:#x}", name_, report_.missing);
    if (report_.status == Status::ok)
      check_item_ranges(report_, columns_->rows, topology,
                        [this](const std::string& what) { complain("{} {}", name_, what); });
  }

  // The values of the row in one dataset, or one part of them after the other: `count` values in all. The
  // first complaint ends a column.
  void check(const DatasetSpec& spec, std::span<const std::byte> values, std::size_t count) {
    if (spec.path != column_) {
      column_ = spec.path;
      seen_.clear();
      at_ = 0;
      points_crc32c_ = 0;
      is_refused_ = false;
    }
    if (is_refused_) return;
    const std::size_t problems = problems_.size();
    at_ += values.size() / value_bytes(spec);
    check_values(spec, values, count);
    is_refused_ = problems_.size() > problems;
  }

 private:
  void check_values(const DatasetSpec& spec, std::span<const std::byte> values, std::size_t count) {
    if (report_.status != Status::ok) return check_fill(spec, values);
    if (spec.path == "/points") {
      points_crc32c_ = crc32c(values, points_crc32c_);
      if (at_ == count && points_crc32c_ != report_.points_crc32c)
        complain("{}: the checksum of its points is {:08x}, points_crc32c says {:08x}", name_, points_crc32c_,
                 report_.points_crc32c);
    }
    // A descriptor that could not be made.
    if (spec.role == Role::descriptor && is_fill(spec, values)) return;
    // A certificate may say that a surface cannot be measured.
    if (spec.path.starts_with("/certificate/")) return;
    if (spec.type == ElementType::f32)
      return check_sample_ranges(spec, numbers_of<float>(values), report_, columns_->rows,
                                 [this](const std::string& what) { complain("{} {}", name_, what); });
    if (spec.type == ElementType::f16) {
      std::vector<float> floats;
      for (const std::uint16_t half : numbers_of<std::uint16_t>(values))
        floats.push_back(value_of_half(half));
      return check_sample_ranges(spec, floats, report_, columns_->rows,
                                 [this](const std::string& what) { complain("{} {}", name_, what); });
    }
    if (spec.type == ElementType::u8 && spec.column != nullptr) return check_bytes(spec, values);
    if (spec.type == ElementType::i32)
      return check_class_ranges(spec, numbers_of<std::int32_t>(values), report_,
                                [this](const std::string& what) { complain("{} {}", name_, what); });
    if (spec.type != ElementType::u32) return;
    const std::vector<std::uint32_t> numbers = numbers_of<std::uint32_t>(values);
    const Values values_are = spec.column == nullptr ? Values::any : spec.column->values;
    if (values_are == Values::sharp_edges) check_edges(spec, numbers);
    if (values_are == Values::faces) check_below(spec, numbers, report_.faces);
    if (values_are == Values::vertices) check_below(spec, numbers, report_.vertices);
    if (values_are == Values::ranks) check_permutation(spec, numbers, count);
  }

  template <class... Arguments>
  void complain(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
    problems_.push_back(fmt::format(text, std::forward<Arguments>(arguments)...));
  }

  template <class Number>
  static std::vector<Number> numbers_of(std::span<const std::byte> values) {
    std::vector<Number> numbers(values.size() / sizeof(Number));
    std::memcpy(numbers.data(), values.data(), values.size());
    return numbers;
  }

  static bool is_fill(const DatasetSpec& spec, std::span<const std::byte> values) {
    std::vector<std::byte> fill(values.size());
    write_fill(spec, fill);
    return std::memcmp(fill.data(), values.data(), fill.size()) == 0;
  }

  void check_fill(const DatasetSpec& spec, std::span<const std::byte> values) {
    if (!is_fill(spec, values)) complain("{} is not ok and {} is not all fill", name_, spec.path);
  }

  void check_below(const DatasetSpec& spec, const std::vector<std::uint32_t>& numbers, std::uint64_t bound) {
    for (const std::uint32_t number : numbers)
      if (number >= bound)
        return complain("{} has {} in {}, which must be below {}", name_, number, spec.path, bound);
  }

  // Of colors, every byte is one.
  void check_bytes(const DatasetSpec& spec, std::span<const std::byte> values) {
    const Values rule = spec.column->values;
    if (rule != Values::truths && rule != Values::groups) return;
    const std::size_t bound = rule == Values::truths ? 2 : columns_->query_groups.size();
    for (const std::byte value : values)
      if (std::to_integer<std::size_t>(value) >= bound)
        return complain("{} has {} in {}, which must be below {}", name_, std::to_integer<std::size_t>(value),
                        spec.path, bound);
  }

  // A model without sharp edges has points on none.
  void check_edges(const DatasetSpec& spec, const std::vector<std::uint32_t>& numbers) {
    for (const std::uint32_t number : numbers)
      if (report_.sharp_edges > 0 ? number >= report_.sharp_edges : number != no_sharp_edge)
        return complain("{} has {} in {}, but {} sharp edges", name_, number, spec.path, report_.sharp_edges);
  }

  void check_permutation(const DatasetSpec& spec, const std::vector<std::uint32_t>& ranks,
                         std::size_t count) {
    seen_.resize(count, false);
    for (const std::uint32_t rank : ranks) {
      if (rank >= count || seen_[rank])
        return complain("{} has {} in {}, which is not an order of 0 .. {}", name_, rank, spec.path,
                        count - 1);
      seen_[rank] = true;
    }
  }

  const std::string name_;
  const ItemReport& report_;
  const StoredColumns& columns_;
  std::vector<std::string>& problems_;
  // The progress in the column that is being checked.
  std::string column_;
  std::size_t at_ = 0;
  std::uint32_t points_crc32c_ = 0;
  std::vector<bool> seen_;  // ranks
  bool is_refused_ = false;
};

// What the run of these parameters did; if they are not understood, what runs do.
bool looked_for_topology(const std::string& parameters_json) {
  try {
    const std::map<std::string, std::string> members = split_members(parameters_json);
    const auto at = members.find("topology");
    return at == members.end() || at->second != "\"none\"";
  } catch (const RunError&) {
    return true;
  }
}

// What is wrong with the names of a row, completing "they are ..."; empty: nothing.
std::string names_problem(const std::string& text) {
  if (text.size() > most_name_bytes) return fmt::format("longer than {} bytes", most_name_bytes);
  try {
    const JsonTree json(text);
    if (!json.root().is_object()) return "no JSON object";
    for (const JsonValue& list : json.root().items()) {
      const std::vector<JsonValue> names = list.items();
      if (!list.is_array() ||
          !std::all_of(names.begin(), names.end(), [](const JsonValue& name) { return name.text(); }))
        return "no lists of texts";
    }
    return {};
  } catch (const ItemError& error) {
    return fmt::format("no JSON: {}", error.what());
  }
}

class Verifier {
 public:
  Verifier(const StoreFileReader& file, std::size_t limit, VerifyResult& result)
      : file_(file),
        layout_(file.layout()),
        limit_(limit),
        result_(result),
        values_(layout_.datasets.size()),
        usable_(layout_.datasets.size()),
        topology_(looked_for_topology(file.facts().parameters_json)) {}

  void check_rows(const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    result_.rows = layout_.rows;
    check_names();
    const std::uint64_t step = rows_at_a_time();
    for (std::uint64_t row = 0; row < layout_.rows && !full(); row += step) {
      const RowRange rows{row, std::min(row + step, layout_.rows)};
      check_stretch(rows);
      if (progress) progress(rows.end, layout_.rows);
    }
  }

 private:
  struct Chunk {
    std::size_t dataset = 0;
    std::uint64_t row = 0;
    std::uint32_t part = 0;
    bool whole = true;
    std::vector<std::byte> filtered{};
  };

  bool full() const { return result_.problems.size() >= limit_; }
  template <class... Arguments>
  void complain(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
    if (!full()) result_.problems.push_back(fmt::format(text, std::forward<Arguments>(arguments)...));
  }

  // Whether the names of every row are where the lengths say, and a text as readers make it.
  void check_names() {
    if (layout_.index_of(names_bytes_path) == layout_.datasets.size()) return;
    try {
      const std::vector<std::uint64_t> ends = file_.read_name_ends();
      const std::uint64_t end = ends.empty() ? 0 : ends.back();
      if (end != file_.names_bytes())
        return complain("{} has {} bytes, of which the rows have {}", names_path, file_.names_bytes(), end);
      std::string text;
      for (std::uint64_t row = 0; row < ends.size() && !full(); ++row) {
        const std::uint64_t begin = row == 0 ? 0 : ends[row - 1];
        text.resize(
            static_cast<std::size_t>(std::min<std::uint64_t>(ends[row] - begin, most_name_bytes + 1)));
        if (text.empty()) continue;
        file_.read_names(begin, std::as_writable_bytes(std::span(text)));
        if (const std::string problem = names_problem(text); !problem.empty())
          complain("row {} has names that are {}", row, problem);
      }
    } catch (const Hdf5Error& error) {
      complain("{}", error.what());
    }
  }

  // Whole chunks of samples, about 32 MiB of them, never across the rows of an ItemBlock.
  std::uint64_t rows_at_a_time() const {
    constexpr std::uint64_t bytes = std::uint64_t{32} << 20;
    if (layout_.datasets[layout_.index_of(Role::samples)].chunk.rows > 1) return sample_chunk_rows;
    std::uint64_t rows = sample_chunk_rows, row_bytes = 0;
    for (const DatasetLayout& dataset : layout_.datasets)
      if (per_sample(dataset.spec)) row_bytes += dataset.row_bytes;
    while (rows > 1 && rows * row_bytes > bytes) rows /= 2;
    return rows;
  }

  void check_stretch(RowRange rows) {
    try {
      if (!items_.holds(rows.begin)) items_.read(file_, rows.begin);
    } catch (const Hdf5Error& error) {
      return complain("rows {} on: {}", rows.begin, error.what());
    }
    usable_.assign(usable_.size(), true);
    if (rows.size() == 1 && most_chunks_per_row(layout_.columns, layout_.rows, layout_.samples) > 1) {
      check_long_row(rows.begin);
      last_id_ = items_.id(rows.begin);
      return;
    }
    read_samples(rows);
    read_descriptors(rows);
    std::vector<std::vector<std::string>> problems(rows.size());
    std::vector<std::uint8_t> ok(rows.size(), 0);
    constexpr std::size_t one_row = parallel_threshold;  // a row is work enough for a task
    parallel_blocks(rows.size() * one_row, one_row, [&](std::size_t begin, std::size_t) {
      ok[begin / one_row] =
          check_row(rows.begin + begin / one_row, begin / one_row, problems[begin / one_row]);
    });
    for (std::uint64_t i = 0; i < rows.size(); ++i) {
      result_.ok_rows += ok[i];
      for (const std::string& problem : problems[i]) complain("{}", problem);
    }
    last_id_ = items_.id(rows.end - 1);
  }

  // A row of many chunks, some of them at a time.
  void check_long_row(std::uint64_t row) {
    read_descriptors({row, row + 1});
    std::vector<std::string> problems;
    const std::string name = fmt::format("row {} ({})", row, items_.id(row));
    const std::optional<ItemReport> report = check_columns(row, 0, name, problems);
    if (report) {
      result_.ok_rows += report->status == Status::ok;
      RowChecker checker(name, *report, layout_.columns, problems);
      for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
        const DatasetLayout& dataset = layout_.datasets[d];
        if (dataset.spec.role ==
            Role::samples)  // lacks says that some value is missing: it needs all of them
          check_long_column(row, d, dataset.spec.lacks_bit.has_value(), checker);
        else if (!values_[d].empty() && usable_[d])
          checker.check(dataset.spec, values_[d], dataset.row_bytes / value_bytes(dataset.spec));
      }
    }
    for (const std::string& problem : problems) complain("{}", problem);
  }

  // whole: its values are checked together.
  void check_long_column(std::uint64_t row, std::size_t d, bool whole, RowChecker& checker) {
    constexpr std::uint32_t some = 4;  // chunks at a time
    const DatasetLayout& dataset = layout_.datasets[d];
    const std::uint32_t parts = dataset.chunk.chunks_per_row;
    const std::uint32_t step = whole ? parts : some;
    std::vector<std::byte> values;
    for (std::uint32_t first = 0; first < parts; first += step) {
      const std::uint32_t count = std::min(step, parts - first);
      // Chunks that were never written read as fill, as those of rows that are not ok do.
      std::vector<Chunk> chunks;
      for (std::uint32_t part = first; part < first + count; ++part)
        if (items_.is_ok(row) || file_.has_chunk(d, row, part)) read_chunk({d, row, part}, chunks);
      if (!usable_[d]) return;
      values.resize(count * dataset.chunk_bytes);
      write_fill(dataset.spec, values);
      parallel_tasks(chunks.size(), [&](std::size_t i) {
        const std::span<std::byte> to =
            std::span(values).subspan((chunks[i].part - first) * dataset.chunk_bytes, dataset.chunk_bytes);
        chunks[i].whole = unfilter(chunks[i].filtered, dataset.element_bytes, layout_.compression, to);
      });
      for (const Chunk& chunk : chunks)
        if (!chunk.whole)
          return complain("chunk {} of row {} of {} fails its checksum", chunk.part, row, dataset.spec.path);
      const std::size_t begin = first * dataset.chunk_bytes;
      checker.check(dataset.spec, std::span(values).first(std::min(values.size(), dataset.row_bytes - begin)),
                    dataset.points);
    }
  }

  // Reads the stored chunks one after the other and decodes them in parallel.
  void read_samples(RowRange rows) {
    std::vector<Chunk> chunks;
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (dataset.spec.role != Role::samples) continue;
      const std::uint64_t stretch_chunks = (rows.size() + dataset.chunk.rows - 1) / dataset.chunk.rows;
      values_[d].resize(stretch_chunks * dataset.chunk.rows * dataset.row_bytes);
      for (std::uint64_t row = rows.begin; row < rows.end; row += dataset.chunk.rows) {
        const RowRange chunk_rows{row, std::min(row + dataset.chunk.rows, rows.end)};
        if (!any_ok(chunk_rows)) {  // not stored, or what is stored must read as fill
          read_through_library(d, chunk_rows, (row - rows.begin) * dataset.row_bytes);
          continue;
        }
        for (std::uint32_t part = 0; part < dataset.chunk.chunks_per_row; ++part)
          read_chunk({d, row, part}, chunks);
      }
    }
    constexpr std::size_t one_chunk = parallel_threshold;
    parallel_blocks(chunks.size() * one_chunk, one_chunk,
                    [&](std::size_t begin, std::size_t) { decode(chunks[begin / one_chunk], rows); });
    for (const Chunk& chunk : chunks) {
      if (chunk.whole) continue;
      const std::string& path = layout_.datasets[chunk.dataset].spec.path;
      complain("the chunk of {} that begins with row {} fails its checksum", path, chunk.row);
      usable_[chunk.dataset] = false;
    }
  }

  void read_chunk(Chunk chunk, std::vector<Chunk>& chunks) {
    try {
      file_.read_chunk(chunk.dataset, chunk.row, chunk.part, chunk.filtered);
    } catch (const Hdf5Error& error) {
      complain("{}", error.what());
      usable_[chunk.dataset] = false;
      return;
    }
    chunks.push_back(std::move(chunk));
  }

  void decode(Chunk& chunk, RowRange rows) {
    const DatasetLayout& dataset = layout_.datasets[chunk.dataset];
    // A chunk is whole rows, or a part of one; the last part of a row is padded.
    const std::size_t begin = (chunk.row - rows.begin) * dataset.row_bytes + chunk.part * dataset.chunk_bytes;
    const std::size_t row_end = (chunk.row - rows.begin + dataset.chunk.rows) * dataset.row_bytes;
    const auto target =
        std::span(values_[chunk.dataset]).subspan(begin, std::min(row_end - begin, dataset.chunk_bytes));
    std::vector<std::byte> decoded(dataset.chunk_bytes);
    chunk.whole = unfilter(chunk.filtered, dataset.element_bytes, layout_.compression, decoded);
    std::copy_n(decoded.begin(), target.size(), target.begin());
    chunk.filtered = {};
  }

  bool any_ok(RowRange rows) const {
    for (std::uint64_t row = rows.begin; row < rows.end; ++row)
      if (items_.is_ok(row)) return true;
    return false;
  }

  void read_through_library(std::size_t d, RowRange rows, std::size_t begin) {
    const DatasetLayout& dataset = layout_.datasets[d];
    try {
      file_.read_rows(d, rows.begin, rows.size(),
                      std::span(values_[d]).subspan(begin, rows.size() * dataset.row_bytes));
    } catch (const Hdf5Error& error) {
      complain("{}", error.what());
      usable_[d] = false;
    }
  }

  void read_descriptors(RowRange rows) {
    for (std::size_t d = 0; d < layout_.datasets.size(); ++d) {
      if (layout_.datasets[d].spec.role != Role::descriptor) continue;
      values_[d].resize(rows.size() * layout_.datasets[d].row_bytes);
      read_through_library(d, rows, 0);
    }
  }

  // The item columns of a row, which is `at` within the stretch; nothing when they cannot be read.
  std::optional<ItemReport> check_columns(std::uint64_t row, std::uint64_t at, const std::string& name,
                                          std::vector<std::string>& problems) const {
    check_id(row, at, name, problems);
    ItemReport report;
    try {
      report = items_.report(row);
      static_cast<void>(items_.split(row));
    } catch (const RunError& error) {
      problems.emplace_back(error.what());
      return std::nullopt;
    }
    const bool ok = report.status == Status::ok;
    if (ok != report.reason.empty())
      problems.push_back(
          fmt::format("{} has status {} and the reason \"{}\"", name, name_of(report.status), report.reason));
    const bool has_notes =
        std::any_of(report.notes.begin(), report.notes.end(), [](std::uint32_t count) { return count > 0; });
    if (has_notes == report.note_text.empty())
      problems.push_back(fmt::format("{} has {} notes and the text \"{}\" of notes", name,
                                     has_notes ? "some" : "no", report.note_text));
    const std::int32_t label = items_.label(row);
    if (label < -1 || (label >= 0 && static_cast<std::size_t>(label) >= file_.facts().label_names.size()))
      problems.push_back(
          fmt::format("{} has label {} of {} classes", name, label, file_.facts().label_names.size()));
    if (!ok && report.names_bytes != 0) problems.push_back(fmt::format("{} is not ok and has names", name));
    if (!ok && report.points_crc32c != 0)
      problems.push_back(fmt::format("{} is not ok and has a checksum of points", name));
    RowChecker(name, report, layout_.columns, problems).check_items(topology_);
    return report;
  }

  // True when the status is ok. `at` is the row within the stretch.
  bool check_row(std::uint64_t row, std::uint64_t at, std::vector<std::string>& problems) const {
    const std::string name = fmt::format("row {} ({})", row, items_.id(row));
    const std::optional<ItemReport> report = check_columns(row, at, name, problems);
    if (!report) return false;
    RowChecker checker(name, *report, layout_.columns, problems);
    for (std::size_t d = 0; d < values_.size(); ++d) {
      if (values_[d].empty() || !usable_[d]) continue;
      const DatasetLayout& dataset = layout_.datasets[d];
      checker.check(dataset.spec, std::span(values_[d]).subspan(at * dataset.row_bytes, dataset.row_bytes),
                    dataset.row_bytes / value_bytes(dataset.spec));
    }
    return report->status == Status::ok;
  }

  // Against the row before it: of this stretch, or the last one of the stretch before.
  void check_id(std::uint64_t row, std::uint64_t at, const std::string& name,
                std::vector<std::string>& problems) const {
    if (row == 0) return;
    const std::string before = at == 0 ? last_id_ : items_.id(row - 1);
    if (items_.id(row) <= before)
      problems.push_back(fmt::format("{} does not come after {} by its id", name, before));
  }

  const StoreFileReader& file_;
  const StoreLayout& layout_;
  const std::size_t limit_;
  VerifyResult& result_;
  ItemBlock items_;
  std::string last_id_;
  std::vector<std::vector<std::byte>> values_;  // of the stretch, per dataset; item columns are in items_
  std::vector<bool> usable_;                    // what could not be read is not judged
  const bool topology_;
};

}  // namespace

namespace {

// Counts and problems of one file with rows, or what an index says of its packs.
VerifyResult verify_file(const std::filesystem::path& path, std::size_t limit,
                         const std::function<void(std::uint64_t, std::uint64_t)>& progress,
                         StoreFacts& facts) {
  VerifyResult result;
  try {
    const std::string damage = check_whole_file(path);
    if (!damage.empty()) {
      // The library is not asked to parse bytes that are known to be wrong: on one flipped bit in six hundred
      // of a small store it crashes or does not come back.
      result.problems.push_back(fmt::format("{} is not a whole store: {}", path.string(), damage));
      return result;
    }
    const Hdf5Lock lock;
    const StoreFileReader file(path);
    facts = file.facts();
    for (const std::string& problem : file.problems())
      if (result.problems.size() < limit) result.problems.push_back(problem);
    if (result.problems.empty() && facts.packs.empty()) Verifier(file, limit, result).check_rows(progress);
  } catch (const std::runtime_error& error) {  // RunError and Hdf5Error
    result.problems.emplace_back(error.what());
  }
  return result;
}

// The first and the last id of a file that was found whole.
std::pair<std::string, std::string> outer_ids(const std::filesystem::path& path) {
  const StoreReader store(path, StoreCheck::none);
  return {store.id(0), store.id(store.rows() - 1)};
}

void verify_packs(const std::filesystem::path& index, const StoreFacts& whole, std::size_t limit,
                  const std::function<void(std::uint64_t, std::uint64_t)>& progress, VerifyResult& result) {
  const auto complain = [&](const std::string& file, const std::string& what) {
    if (result.problems.size() < limit) result.problems.push_back(fmt::format("{}: {}", file, what));
  };
  std::string last_id;
  for (const StorePack& pack : whole.packs) {
    const std::filesystem::path path = index.parent_path() / pack.file;
    const std::uint64_t before = result.rows;
    result.rows += pack.rows;
    try {
      if (const std::string differs = difference_to_pack(path, pack); !differs.empty()) {
        complain(index.string(), differs);
        continue;
      }
      StoreFacts facts;
      const VerifyResult part = verify_file(
          path, limit,
          [&](std::uint64_t done, std::uint64_t) {
            if (progress) progress(before + done, whole.rows);
          },
          facts);
      result.ok_rows += part.ok_rows;
      for (const std::string& problem : part.problems) complain(pack.file, problem);
      if (!part.problems.empty()) continue;
      if (facts.rows != pack.rows || facts.parameters_json != whole.parameters_json ||
          facts.label_names != whole.label_names || !(facts.columns == whole.columns))
        complain(pack.file, "it belongs to another store than its index");
      const auto [first, last] = outer_ids(path);
      if (first != pack.first_id || (before > 0 && first <= last_id))
        complain(pack.file, fmt::format("its first item {} is not in its place", first));
      last_id = last;
    } catch (const std::runtime_error& error) {
      complain(pack.file, error.what());
    }
  }
  if (result.rows != whole.rows)
    complain(index.string(), fmt::format("its packs have {} rows of {}", result.rows, whole.rows));
}

}  // namespace

VerifyResult verify_store(const std::filesystem::path& store, std::size_t limit,
                          const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  StoreFacts facts;
  VerifyResult result = verify_file(store, limit, progress, facts);
  if (!facts.packs.empty() && result.problems.empty()) verify_packs(store, facts, limit, progress, result);
  return result;
}

}  // namespace meander
