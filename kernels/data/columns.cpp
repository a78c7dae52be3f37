#include "kernels/data/columns.h"

#include <concepts>

namespace meander {

namespace {

template <class Value>
constexpr ElementType element_of = std::same_as<Value, float>           ? ElementType::f32
                                   : std::same_as<Value, double>        ? ElementType::f64
                                   : std::same_as<Value, std::uint8_t>  ? ElementType::u8
                                   : std::same_as<Value, std::uint32_t> ? ElementType::u32
                                                                        : ElementType::u64;

struct TypeOf {
  template <class Value>
  ColumnType operator()(Value ItemReport::*) const {
    return {element_of<Value>};
  }
  template <class Value, std::size_t Count>
  ColumnType operator()(std::array<Value, Count> ItemReport::*) const {
    return {element_of<Value>, Count};
  }
  ColumnType operator()(std::array<std::uint32_t, note_count> ItemReport::*) const {
    return {ElementType::u32, note_count, {}, note_names};
  }
  ColumnType operator()(RepairCounts ItemReport::*) const {
    return {ElementType::u32, repair_count, {}, repair_names};
  }
  ColumnType operator()(std::string ItemReport::*) const { return {ElementType::text, note_text_width}; }
  ColumnType operator()(Status ItemReport::*) const { return {ElementType::word, 0, status_names}; }
  ColumnType operator()(Method ItemReport::*) const { return {ElementType::word, 0, method_names}; }
  ColumnType operator()(OrderReason ItemReport::*) const {
    return {ElementType::word, 0, order_reason_names};
  }
  ColumnType operator()(ColorSource ItemReport::*) const {
    return {ElementType::word, 0, color_source_names};
  }
  ColumnType operator()(SignRule ItemReport::*) const { return {ElementType::word, 0, sign_rule_names}; }
  ColumnType operator()(ItemKey key) const {
    if (key == ItemKey::label) return {ElementType::i32, 1};
    return key == ItemKey::split ? ColumnType{ElementType::word, 0, split_names}
                                 : ColumnType{ElementType::text};
  }
  template <class Value>
  ColumnType operator()(std::vector<Value> Samples::*) const {
    return {element_of<Value>};
  }
};

}  // namespace

ColumnType type_of(const SampleColumn& column) {
  ColumnType type = std::visit(TypeOf(), column.array);
  return type.width = column.width, type;
}

ColumnType type_of(const ItemColumn& column) { return std::visit(TypeOf(), column.member); }

}  // namespace meander
