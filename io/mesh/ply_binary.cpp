#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <string>
#include <type_traits>

#include "io/mesh/byte_order.h"
#include "io/mesh/ply_rows.h"
#include "io/mesh/text_cursor.h"
#include "kernels/core/large_vector.h"
#include "kernels/core/parallel.h"

namespace meander {

namespace {

// Calls action(T{}) with the C++ type of a PLY type.
template <class Action>
auto with_type(PlyType type, const Action& action) {
  switch (type) {
    case PlyType::int8:
      return action(std::int8_t{});
    case PlyType::uint8:
      return action(std::uint8_t{});
    case PlyType::int16:
      return action(std::int16_t{});
    case PlyType::uint16:
      return action(std::uint16_t{});
    case PlyType::int32:
      return action(std::int32_t{});
    case PlyType::uint32:
      return action(std::uint32_t{});
    case PlyType::float32:
      return action(float{});
    case PlyType::int64:
      return action(std::int64_t{});
    case PlyType::uint64:
      return action(std::uint64_t{});
    case PlyType::float64:
      break;
  }
  return action(double{});
}

template <class T>
std::uint32_t index_of(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    return value >= 0 && value < static_cast<T>(4e9) ? static_cast<std::uint32_t>(value) : no_index;
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    return value < no_index ? static_cast<std::uint32_t>(value) : no_index;
  } else {
    return text::to_index(value);
  }
}

// The length of a list; -1 for what is none.
template <class T>
std::int64_t length_of(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    return value >= 0 && value < static_cast<T>(4e9) && value == std::floor(value)
               ? static_cast<std::int64_t>(value)
               : -1;
  } else if constexpr (std::is_same_v<T, std::uint64_t>) {
    return value < no_index ? static_cast<std::int64_t>(value) : -1;
  } else {
    return static_cast<std::int64_t>(value);
  }
}

// One property of `rows` rows that lie `stride` apart.
template <class Out>
void gather(PlyType type, const char* from, std::size_t stride, std::size_t rows, bool swap, Out* to,
            std::size_t to_stride) {
  with_type(type, [&](auto sample) {
    for (std::size_t r = 0; r < rows; ++r)
      to[r * to_stride] = static_cast<Out>(load<decltype(sample)>(from + r * stride, swap));
    return 0;
  });
}

void gather_numbers(PlyType type, const char* from, bool swap, std::size_t length, PlyNumberList& list) {
  const std::size_t begin = list.values.size();
  list.values.resize(begin + length);
  gather(type, from, bytes_of(type), length, swap, list.values.data() + begin, 1);
  list.begin.push_back(list.values.size());
}

void gather_indices(PlyType type, const char* from, std::size_t stride, std::size_t rows, bool swap,
                    std::size_t length, std::uint32_t* to) {
  with_type(type, [&](auto sample) {
    for (std::size_t r = 0; r < rows; ++r)
      for (std::size_t k = 0; k < length; ++k)
        *to++ = index_of(load<decltype(sample)>(from + r * stride + k * sizeof sample, swap));
    return 0;
  });
}

std::int64_t load_count(PlyType type, const char* from, bool swap) {
  return with_type(type, [&](auto sample) { return length_of(load<decltype(sample)>(from, swap)); });
}

void store(PlyType type, const char* from, bool swap, const PlyColumns::Column& column, std::size_t row) {
  if (column.values != nullptr) gather(type, from, 0, 1, swap, column.values + row, 1);
  if (column.normals != nullptr) gather(type, from, 0, 1, swap, column.normals + 3 * row, 3);
}

// The length of each list in the row at `from` (0 for scalars) and the bytes of the row; false when the data
// ends in it or a length is negative.
bool measure_row(std::string_view data, const PlyElement& element, bool swap,
                 std::vector<std::size_t>& lengths, std::size_t& row_bytes) {
  lengths.assign(element.properties.size(), 0);
  row_bytes = 0;
  for (std::size_t p = 0; p < element.properties.size(); ++p) {
    const PlyProperty& property = element.properties[p];
    const std::size_t bytes = bytes_of(property.is_list ? property.count_type : property.type);
    if (bytes > data.size() - row_bytes) return false;
    if (property.is_list) {
      const std::int64_t length = load_count(property.count_type, data.data() + row_bytes, swap);
      const std::size_t left = data.size() - row_bytes - bytes;
      if (length < 0 || static_cast<std::uint64_t>(length) > left / bytes_of(property.type)) return false;
      lengths[p] = static_cast<std::size_t>(length);
    }
    row_bytes += bytes + lengths[p] * bytes_of(property.type);
  }
  return true;
}

// Rows that all have the size of the first one.
class EqualRows {
 public:
  EqualRows(std::string_view data, const PlyElement& element, bool swap, std::vector<std::size_t> lengths,
            std::size_t row_bytes)
      : data_(data), element_(element), swap_(swap), lengths_(std::move(lengths)), row_bytes_(row_bytes) {}

  // Whether the rows [begin, end) state the lengths of the first one.
  bool hold(std::size_t begin, std::size_t end) const {
    std::size_t offset = 0;
    for (std::size_t p = 0; p < lengths_.size(); ++p) {
      const PlyProperty& property = element_.properties[p];
      if (property.is_list) {
        const auto expected = static_cast<std::int64_t>(lengths_[p]);
        const bool same = with_type(property.count_type, [&](auto sample) {
          bool all = true;
          for (std::size_t r = begin; r < end; ++r)
            all = all && length_of(load<decltype(sample)>(at(r) + offset, swap_)) == expected;
          return all;
        });
        if (!same) return false;
      }
      offset += property_bytes(p);
    }
    return true;
  }

  void gather_rows(std::size_t begin, std::size_t end, const PlyColumns& columns,
                   PolygonPart& polygons) const {
    const std::size_t rows = end - begin;
    std::size_t offset = 0;
    for (std::size_t p = 0; p < lengths_.size(); ++p) {
      const PlyProperty& property = element_.properties[p];
      const char* const from = at(begin) + offset;
      const PlyColumns::Column& column = columns.columns[p];
      if (column.values != nullptr)
        gather(property.type, from, row_bytes_, rows, swap_, column.values + begin, 1);
      if (column.normals != nullptr)
        gather(property.type, from, row_bytes_, rows, swap_, column.normals + 3 * begin, 3);
      if (columns.index_list == static_cast<int>(p)) {
        gather_indices(property.type, from + bytes_of(property.count_type), row_bytes_, rows, swap_,
                       lengths_[p], polygons.corners.data() + begin * lengths_[p]);
        for (std::size_t r = begin; r < end; ++r)
          polygons.begin[r + 1] = static_cast<std::uint32_t>((r + 1) * lengths_[p]);
      }
      offset += property_bytes(p);
    }
  }

 private:
  const char* at(std::size_t row) const { return data_.data() + row * row_bytes_; }
  std::size_t property_bytes(std::size_t p) const {
    const PlyProperty& property = element_.properties[p];
    return (property.is_list ? bytes_of(property.count_type) + lengths_[p] * bytes_of(property.type)
                             : bytes_of(property.type));
  }

  std::string_view data_;
  const PlyElement& element_;
  bool swap_;
  std::vector<std::size_t> lengths_;
  std::size_t row_bytes_;
};

// Reads the rows behind those that `progress` counts, one after the other, whatever their lengths.
PlyProgress read_in_order(std::string_view data, PlyProgress progress, const PlyElement& element, bool swap,
                          const PlyColumns& columns, PolygonPart& polygons, const CancelToken& cancel) {
  std::vector<std::size_t> lengths;
  std::size_t row_bytes = 0;
  for (; progress.rows < element.count; ++progress.rows) {
    if (progress.rows % 65536 == 0) cancel.check();
    const std::string_view row = data.substr(progress.bytes);
    if (!measure_row(row, element, swap, lengths, row_bytes)) break;
    const char* from = row.data();
    for (std::size_t p = 0; p < lengths.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (!property.is_list) {
        store(property.type, from, swap, columns.columns[p], progress.rows);
        from += bytes_of(property.type);
        continue;
      }
      from += bytes_of(property.count_type);
      if (columns.index_list == static_cast<int>(p)) {
        check_count(std::uint64_t{polygons.corners.size()} + lengths[p], "corners");
        polygons.corners.resize(polygons.corners.size() + lengths[p]);
        gather_indices(property.type, from, 0, 1, swap, lengths[p],
                       polygons.corners.data() + polygons.begin.back());
        polygons.close_polygon();
      }
      if (columns.number_list == static_cast<int>(p))
        gather_numbers(property.type, from, swap, lengths[p], *columns.numbers);
      from += lengths[p] * bytes_of(property.type);
    }
    progress.bytes += row_bytes;
  }
  return progress;
}

}  // namespace

PlyProgress read_binary_rows(std::string_view data, const PlyElement& element, bool swap,
                             const PlyColumns& columns, PolygonPart& polygons, const CancelToken& cancel,
                             const BlockRule& rule) {
  if (element.properties.empty()) return {element.count, 0};
  std::vector<std::size_t> lengths;
  std::size_t row_bytes = 0;
  if (element.count == 0 || !measure_row(data, element, swap, lengths, row_bytes)) return {};
  const std::size_t rows = std::min<std::uint64_t>(element.count, data.size() / row_bytes);
  const std::size_t block = std::max<std::size_t>(1, rule.block_bytes / row_bytes);
  const std::size_t corners =
      columns.index_list < 0 ? 0 : rows * lengths[static_cast<std::size_t>(columns.index_list)];
  const EqualRows equal(data, element, swap, std::move(lengths), row_bytes);
  std::atomic<bool> regular{true};
  if (element.has_lists())
    parallel_blocks(rows, block, [&](std::size_t begin, std::size_t end) {
      if (regular.load(std::memory_order_relaxed) && !equal.hold(begin, end)) regular.store(false);
    });
  if (!regular.load() || columns.number_list >= 0)
    return read_in_order(data, {}, element, swap, columns, polygons, cancel);
  if (columns.index_list >= 0) {
    check_count(corners, "corners");
    resize_large(polygons.begin, rows + 1);
    resize_large(polygons.corners, corners);
  }
  parallel_blocks(rows, block, [&](std::size_t begin, std::size_t end) {
    cancel.check();
    equal.gather_rows(begin, end, columns, polygons);
  });
  // Where no more rows of this size fit, shorter ones may.
  return read_in_order(data, {rows, rows * row_bytes}, element, swap, columns, polygons, cancel);
}

void check_positions(const PlyElement& vertices) {
  for (const char* const name : {"x", "y", "z"})
    if (vertices.scalar_named(name) < 0)
      throw ItemError(Status::unreadable, std::string("the element vertex has no property ") + name);
}

void place_vertices(const PlyElement& vertices, std::uint64_t rows,
                    std::array<std::vector<double>*, 3> positions, std::vector<float>& normals,
                    PlyColumns& columns) {
  const auto column = [&](const char* name) -> PlyColumns::Column& {
    return columns.columns[static_cast<std::size_t>(vertices.scalar_named(name))];
  };
  static constexpr std::array<const char*, 3> axes = {"x", "y", "z"}, components = {"nx", "ny", "nz"};
  for (std::size_t k = 0; k < 3; ++k) {
    positions[k]->resize(rows);
    column(axes[k]).values = positions[k]->data();
  }
  if (std::any_of(components.begin(), components.end(),
                  [&](const char* name) { return vertices.scalar_named(name) < 0; }))
    return;
  normals.resize(3 * rows);
  for (std::size_t k = 0; k < 3; ++k) column(components[k]).normals = normals.data() + k;
}

PolygonPart triangles_of_strips(const std::vector<PolygonPart>& strips) {
  PolygonPart triangles;
  for (const PolygonPart& part : strips)
    for (std::size_t s = 0; s < part.count(); ++s) {
      std::uint32_t a = no_index, b = no_index;
      std::size_t length = 0;  // corners since the last restart
      for (std::size_t c = part.begin[s]; c < part.begin[s + 1]; ++c) {
        const std::uint32_t corner = part.corners[c];
        length = corner == no_index ? 0 : length + 1;
        if (length >= 3) {
          const bool turned = length % 2 == 0;
          triangles.corners.insert(triangles.corners.end(), {turned ? b : a, turned ? a : b, corner});
          triangles.close_polygon();
        }
        a = b;
        b = corner;
      }
    }
  return triangles;
}

}  // namespace meander
