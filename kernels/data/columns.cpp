#include "kernels/data/columns.h"

#include <concepts>

namespace meander {

namespace {

template <class Value>
constexpr ElementType element_of() {
  if constexpr (std::same_as<Value, float>) return ElementType::f32;
  if constexpr (std::same_as<Value, double>) return ElementType::f64;
  if constexpr (std::same_as<Value, std::uint8_t>) return ElementType::u8;
  if constexpr (std::same_as<Value, std::uint32_t>) return ElementType::u32;
  if constexpr (std::same_as<Value, std::uint64_t>) return ElementType::u64;
}

template <class Value>
ColumnType type_of_member(Value ItemReport::*) {
  return {element_of<Value>()};
}
template <class Value, std::size_t Count>
ColumnType type_of_member(std::array<Value, Count> ItemReport::*) {
  return {element_of<Value>(), Count};
}
ColumnType type_of_member(std::array<std::uint32_t, note_count> ItemReport::*) {
  return {ElementType::u32, note_count, {}, note_names};
}
ColumnType type_of_member(RepairCounts ItemReport::*) {
  return {ElementType::u32, repair_count, {}, repair_names};
}
ColumnType type_of_member(std::string ItemReport::*) { return {ElementType::text, note_text_width}; }
ColumnType type_of_member(Status ItemReport::*) { return {ElementType::word, 0, status_names}; }
ColumnType type_of_member(Method ItemReport::*) { return {ElementType::word, 0, method_names}; }
ColumnType type_of_member(OrderReason ItemReport::*) { return {ElementType::word, 0, order_reason_names}; }
ColumnType type_of_member(ColorSource ItemReport::*) { return {ElementType::word, 0, color_source_names}; }
ColumnType type_of_member(ItemKey key) {
  if (key == ItemKey::label) return {ElementType::i32, 1};
  if (key == ItemKey::split) return {ElementType::word, 0, split_names};
  return {ElementType::text};
}

}  // namespace

ColumnType type_of(const SampleColumn& column) {
  return std::visit(
      [&]<class Value>(std::vector<Value> Samples::*) {
        return ColumnType{element_of<Value>(), column.width};
      },
      column.array);
}

ColumnType type_of(const ItemColumn& column) {
  return std::visit([](auto member) { return type_of_member(member); }, column.member);
}

}  // namespace meander
