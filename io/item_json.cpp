#include "io/item_json.h"

#include <array>
#include <concepts>
#include <type_traits>

#include "io/digest.h"

namespace meander {

void write_item(JsonWriter& json, const ItemColumn& column, const ItemReport& report,
                const std::function<void(double)>& real) {
  const auto write = [&]<class Value>(const Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      json.value(name_of(value));
    } else if constexpr (std::same_as<Value, double>) {
      real(value);
    } else if constexpr (std::same_as<Value, std::array<std::uint8_t, 32>>) {
      json.value(hex_text(value));
    } else if constexpr (requires { typename std::tuple_size<Value>::type; }) {
      json.begin_array();
      for (const double number : value) real(number);
      json.end_array();
    } else {
      json.value(value);
    }
  };
  const auto write_counts = [&](std::span<const std::uint32_t> counts) {
    json.begin_object();
    for (std::size_t i = 0; i < counts.size(); ++i)
      if (counts[i] > 0) json.member(type_of(column).names[i], counts[i]);
    json.end_object();
  };
  std::visit(
      [&]<class Member>(Member member) {
        if constexpr (!std::same_as<Member, ItemKey>) {
          json.key(column.short_name());
          if constexpr (std::same_as<Member, RepairCounts ItemReport::*>)
            write_counts((report.*member).counts);
          else if constexpr (std::same_as<Member, std::array<std::uint32_t, note_count> ItemReport::*>)
            write_counts(report.*member);
          else
            write(report.*member);
        }
      },
      column.member);
}

}  // namespace meander
