#include "jobs/rows/described_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <future>

#include "io/store/crc32c.h"
#include "jobs/cli/usage_error.h"
#include "jobs/rows/descriptor_choice.h"
#include "kernels/core/joined_texts.h"
#include "kernels/core/spelling.h"

namespace meander {

namespace {

constexpr double most_weight = 1000000;  // written without an exponent, whose sign would part terms

}  // namespace

std::vector<NamedTerm> parse_terms(const std::string& text) {
  std::vector<NamedTerm> terms;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('+', begin), text.size());
    const std::string term = text.substr(begin, end - begin);
    const std::size_t sign = std::min(term.find('='), term.size());
    NamedTerm& named = terms.emplace_back(NamedTerm{term.substr(0, sign)});
    if (sign < term.size()) {
      const char* const last = term.data() + term.size();
      const auto [stop, error] = std::from_chars(term.data() + sign + 1, last, named.weight);
      if (error != std::errc() || stop != last || !(named.weight > 0) || !(named.weight <= most_weight))
        throw UsageError(
            fmt::format("`{}`: a weight is a positive number up to {}, as in pairs=2+d2", term, most_weight));
    }
    begin = end + 1;
  }
  if (terms.size() == 1 && terms[0].weight != 1)
    throw UsageError(
        fmt::format("`{}`: a weight is relative to other descriptors, as in pairs=2+d2: leave it out", text));
  return terms;
}

namespace {

void append_term(std::string& text, const std::string& name, double weight) {
  text += (text.empty() ? "" : "+") + name;
  if (weight != 1) text += fmt::format("={}", weight);
}

}  // namespace

std::string joined(std::span<const NamedTerm> terms) {
  std::string text;
  for (const NamedTerm& term : terms) append_term(text, term.name, term.weight);
  return text;
}

std::string joined(std::span<const DescriptorTerm> terms) {
  std::string text;
  for (const DescriptorTerm& term : terms) append_term(text, term.schema.name, term.weight);
  return text;
}

std::string side_checksums(std::span<const DescriptorTerm> terms) {
  std::string text;
  for (const DescriptorTerm& term : terms)
    if (term.side) text += fmt::format("{:08x}\n", crc32c(std::span<const float>(term.side->values)));
  return text;
}

std::vector<float> DescriptorTerm::read(const StoreReader& store, std::uint64_t first,
                                        std::uint64_t count) const {
  if (!side) return store.read_descriptor(schema.name, first, count);
  const auto begin = side->values.begin() + static_cast<std::ptrdiff_t>(first * schema.width);
  return {begin, begin + static_cast<std::ptrdiff_t>(count * schema.width)};
}

std::vector<DescriptorTerm> chosen_descriptors(const StoreReader& store, const std::string& wanted,
                                               const SideVectorsList& side) {
  std::vector<DescriptorTerm> there;
  std::vector<std::string> names;
  for (const DescriptorSchema& schema : store.descriptors())
    if (schema.group == "descriptors") there.push_back({schema});
  for (const std::shared_ptr<const SideVectors>& vectors : side)
    there.push_back({vectors->schema, 1, vectors});
  for (const DescriptorTerm& term : there) names.push_back(term.schema.name);
  if (there.empty()) throw UsageError("the store has no descriptors to compare models by");
  if (wanted.empty()) return {there.front()};
  std::vector<DescriptorTerm> chosen;
  for (const NamedTerm& term : parse_terms(wanted)) {
    const auto at = std::find(names.begin(), names.end(), term.name);
    if (at == names.end()) {
      const std::string near = nearest(term.name, names);
      throw UsageError(fmt::format("the store has no descriptor `{}`{}; it has {}", term.name,
                                   near.empty() ? "" : ", did you mean `" + near + "`?",
                                   joined_texts(names)));
    }
    chosen.push_back(there[static_cast<std::size_t>(at - names.begin())]);
    chosen.back().weight = term.weight;
  }
  return chosen;
}

void DescribedBlock::read(const StoreReader& store, std::span<const DescriptorTerm> terms,
                          std::uint64_t first, std::uint64_t count) {
  first_ = first;
  count_ = count;
  widths_.clear();
  values_.clear();
  for (const DescriptorTerm& term : terms) {
    widths_.push_back(term.schema.width);
    values_.push_back(term.read(store, first, count));
  }
  described_.assign(count, 1);
  for (std::size_t t = 0; t < terms.size(); ++t)
    for (std::uint64_t i = 0; i < count; ++i)
      if (!meander::is_described(terms[t].schema, values(t, first + i))) described_[i] = 0;
}

void visit_described(const StoreReader& store, std::span<const DescriptorTerm> terms, std::uint64_t rows,
                     const std::function<void(const DescribedBlock&)>& visit) {
  if (rows == 0) rows = described_block_rows;
  const auto count = [&](std::uint64_t first) { return std::min(rows, store.rows() - first); };
  DescribedBlock present, next;
  if (store.rows() > 0) next.read(store, terms, 0, count(0));
  for (std::uint64_t first = 0; first < store.rows(); first += rows) {
    std::swap(present, next);
    std::future<void> reading;  // its destructor waits
    const std::uint64_t behind = first + rows;
    if (behind < store.rows())
      reading = std::async(std::launch::async, [&] { next.read(store, terms, behind, count(behind)); });
    visit(present);
    if (reading.valid()) reading.get();
  }
}

std::vector<std::pair<std::string, std::uint64_t>> count_undescribed(const StoreReader& store) {
  std::vector<std::pair<std::string, std::uint64_t>> counts;
  for (const DescriptorSchema& schema : store.descriptors()) {
    if (schema.group != "descriptors") continue;
    std::uint64_t& lacking = counts.emplace_back(schema.name, 0).second;
    const DescriptorTerm term{schema};
    visit_described(store, {&term, 1}, 0, [&](const DescribedBlock& block) {
      for (std::uint64_t row = block.first(); row < block.first() + block.count(); ++row)
        lacking += !block.is_described(row) && store.report(row).status == Status::ok;
    });
  }
  return counts;
}

std::uint64_t described_row_bytes(std::span<const DescriptorTerm> terms) {
  std::uint64_t bytes = 1;
  for (const DescriptorTerm& term : terms) bytes += sizeof(float) * std::uint64_t{term.schema.width};
  return bytes;
}

}  // namespace meander
