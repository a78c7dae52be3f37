#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "io/store/crc32c.h"
#include "io/store/item_block.h"
#include "io/store/store_file.h"

namespace meander {

using namespace store;

namespace {

class Verifier {
 public:
  Verifier(const StoreFileReader& file, std::size_t limit, VerifyResult& result)
      : file_(file), layout_(file.layout()), limit_(limit), result_(result) {}

  void check_rows(const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
    result_.rows = layout_.rows;
    // Whole chunks of samples at a time, so that every chunk is decoded once.
    const std::uint64_t step = layout_.datasets[layout_.index_of(Role::samples)].chunk.rows;
    for (std::uint64_t row = 0; row < layout_.rows && !full(); row += step) {
      const std::uint64_t count = std::min(step, layout_.rows - row);
      check_stretch(row, count);
      if (progress) progress(row + count, layout_.rows);
    }
  }

 private:
  bool full() const { return result_.problems.size() >= limit_; }
  template <class... Arguments>
  void complain(fmt::format_string<Arguments...> text, Arguments&&... arguments) {
    if (!full()) result_.problems.push_back(fmt::format(text, std::forward<Arguments>(arguments)...));
  }

  void check_stretch(std::uint64_t begin, std::uint64_t count) {
    try {
      if (!items_.holds(begin)) items_.read(file_, begin);
    } catch (const Hdf5Error& error) {
      complain("rows {} on: {}", begin, error.what());
      return;
    }
    std::vector<std::vector<std::byte>> values(layout_.datasets.size());
    for (std::size_t d = 0; d < values.size(); ++d) {
      const DatasetLayout& dataset = layout_.datasets[d];
      if (dataset.spec.role != Role::samples && dataset.spec.role != Role::descriptor) continue;
      values[d].resize(count * dataset.row_bytes);
      try {
        file_.read_rows(d, begin, count, values[d]);
      } catch (const Hdf5Error& error) {
        complain("{}", error.what());
        values[d].clear();
      }
    }
    for (std::uint64_t row = begin; row < begin + count && !full(); ++row)
      check_row(row, row - begin, values);
  }

  void check_row(std::uint64_t row, std::uint64_t at, const std::vector<std::vector<std::byte>>& values) {
    const std::string id = items_.id(row);
    // A name of a row in every sentence: the number and the id.
    const std::string name = fmt::format("row {} ({})", row, id);
    if (row > 0 && id <= last_id_) complain("{} does not come after {} by its id", name, last_id_);
    last_id_ = id;
    ItemReport report;
    try {
      report = items_.report(row);
    } catch (const RunError& error) {
      complain("{}", error.what());
      return;
    }
    const bool ok = report.status == Status::ok;
    if (ok) ++result_.ok_rows;
    if (ok != report.reason.empty())
      complain("{} has status {} and the reason \"{}\"", name, name_of(report.status), report.reason);
    const std::int32_t label = items_.label(row);
    if (label < -1 || (label >= 0 && static_cast<std::size_t>(label) >= file_.facts().label_names.size()))
      complain("{} has label {} of {} classes", name, label, file_.facts().label_names.size());
    for (std::size_t d = 0; d < values.size(); ++d) {
      if (values[d].empty()) continue;
      const DatasetLayout& dataset = layout_.datasets[d];
      const std::span<const std::byte> row_values(values[d].data() + at * dataset.row_bytes,
                                                  dataset.row_bytes);
      if (ok)
        check_values(name, dataset.spec, row_values, report);
      else
        check_fill(name, dataset.spec, row_values);
    }
    if (!ok && report.points_crc32c != 0) complain("{} is not ok and has a checksum of points", name);
  }

  void check_fill(const std::string& name, const DatasetSpec& spec, std::span<const std::byte> values) {
    std::vector<std::byte> fill(values.size());
    write_fill(spec, fill);
    if (std::memcmp(fill.data(), values.data(), fill.size()) != 0)
      complain("{} is not ok and {} is not all fill", name, spec.path);
  }

  void check_values(const std::string& name, const DatasetSpec& spec, std::span<const std::byte> values,
                    const ItemReport& report) {
    if (spec.path == "/points" && crc32c(values) != report.points_crc32c)
      complain("{}: the checksum of its points is {:08x}, points_crc32c says {:08x}", name, crc32c(values),
               report.points_crc32c);
    if (spec.type == ElementType::f32) return check_finite(name, spec, values);
    std::vector<std::uint32_t> numbers(values.size() / sizeof(std::uint32_t));
    std::memcpy(numbers.data(), values.data(), values.size());
    if (spec.path == "/face") check_below(name, spec, numbers, report.faces);
    if (spec.path == "/corners") check_below(name, spec, numbers, 0xFFFFFFFFu);
    if (spec.path == "/curve_rank") check_permutation(name, spec, numbers);
  }

  void check_finite(const std::string& name, const DatasetSpec& spec, std::span<const std::byte> values) {
    for (std::size_t at = 0; at < values.size(); at += sizeof(float)) {
      float value;
      std::memcpy(&value, values.data() + at, sizeof value);
      if (!std::isfinite(value)) return complain("{} has a value in {} that is not finite", name, spec.path);
    }
  }

  void check_below(const std::string& name, const DatasetSpec& spec,
                   const std::vector<std::uint32_t>& numbers, std::uint64_t bound) {
    for (const std::uint32_t number : numbers)
      if (number >= bound)
        return complain("{} has {} in {}, which must be below {}", name, number, spec.path, bound);
  }

  void check_permutation(const std::string& name, const DatasetSpec& spec,
                         const std::vector<std::uint32_t>& ranks) {
    std::vector<bool> seen(ranks.size(), false);
    for (const std::uint32_t rank : ranks) {
      if (rank >= ranks.size() || seen[rank])
        return complain("{} has {} in {}, which is not an order of 0 .. {}", name, rank, spec.path,
                        ranks.size() - 1);
      seen[rank] = true;
    }
  }

  const StoreFileReader& file_;
  const StoreLayout& layout_;
  const std::size_t limit_;
  VerifyResult& result_;
  ItemBlock items_;
  std::string last_id_;
};

}  // namespace

VerifyResult verify_store(const std::filesystem::path& store, std::size_t limit,
                          const std::function<void(std::uint64_t, std::uint64_t)>& progress) {
  VerifyResult result;
  try {
    const std::string damage = check_whole_file(store);
    if (!damage.empty()) {
      // The library is not asked to parse bytes that are known to be wrong.
      result.problems.push_back(damage);
      return result;
    }
    const Hdf5Lock lock;
    const StoreFileReader file(store);
    for (const std::string& problem : file.problems())
      if (result.problems.size() < limit) result.problems.push_back(problem);
    if (file.facts().shard) result.problems.push_back("this is a part of an unfinished run, not a store");
    if (result.problems.empty()) Verifier(file, limit, result).check_rows(progress);
  } catch (const std::runtime_error& error) {  // RunError and Hdf5Error
    result.problems.emplace_back(error.what());
  }
  return result;
}

}  // namespace meander
