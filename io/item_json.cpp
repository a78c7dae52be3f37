#include "io/item_json.h"

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

#include "io/digest.h"

namespace meander {

namespace {

using Real = std::function<void(double)>;

void write(JsonWriter& json, double number, const Real& real) { real ? real(number) : json.value(number); }
void write(JsonWriter& json, std::uint32_t number, const Real&) { json.value(number); }
void write(JsonWriter& json, std::uint64_t number, const Real&) { json.value(number); }
void write(JsonWriter& json, const std::string& text, const Real&) { json.value(text); }
void write(JsonWriter& json, const std::array<std::uint8_t, 32>& digest, const Real&) {
  json.value(hex_text(digest));
}
template <std::size_t Count>
void write(JsonWriter& json, const std::array<double, Count>& numbers, const Real& real) {
  json.begin_array();
  for (const double number : numbers) write(json, number, real);
  json.end_array();
}
void write_counts(JsonWriter& json, std::span<const std::uint32_t> counts,
                  std::span<const std::string_view> names) {
  json.begin_object();
  for (std::size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > 0) json.member(names[i], counts[i]);
  json.end_object();
}
void write(JsonWriter& json, const RepairCounts& repairs, const Real&) {
  write_counts(json, repairs.counts, repair_names);
}
void write(JsonWriter& json, const std::array<std::uint32_t, note_count>& notes, const Real&) {
  write_counts(json, notes, note_names);
}
template <class Word>
requires std::is_enum_v<Word>
void write(JsonWriter& json, Word word, const Real&) { json.value(name_of(word)); }

}  // namespace

void write_item(JsonWriter& json, const ItemColumn& column, const ItemReport& report, const Real& real) {
  std::visit(
      [&]<class Member>(Member member) {
        if constexpr (!std::is_same_v<Member, ItemKey>) {
          json.key(column.short_name());
          write(json, report.*member, real);
        }
      },
      column.member);
}

}  // namespace meander
