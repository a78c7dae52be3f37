#include "io/mesh/gltf_data.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <type_traits>
#include <utility>

#include "io/mesh/byte_order.h"
#include "io/mesh/format_readers.h"
#include "io/mesh/gltf_extensions.h"
#include "io/mesh/text_cursor.h"
#include "io/utf8.h"

namespace meander {

namespace {

constexpr bool is_big_endian = std::endian::native == std::endian::big;
constexpr std::size_t elements_between_checks = 65536;

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  const int letter = std::tolower(static_cast<unsigned char>(c));
  return letter >= 'a' && letter <= 'f' ? letter - 'a' + 10 : -1;
}

// A percent sign that no two digits follow stands for itself, as browsers take it.
std::string percent_decoded(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t at = 0; at < text.size(); ++at) {
    const int high = text[at] == '%' && at + 2 < text.size() ? hex_digit(text[at + 1]) : -1;
    const int low = high >= 0 ? hex_digit(text[at + 2]) : -1;
    if (low < 0) {
      out += text[at];
      continue;
    }
    out += static_cast<char>(16 * high + low);
    at += 2;
  }
  return out;
}

bool has_scheme(std::string_view uri) {
  const std::size_t colon = uri.find(':');
  return colon != std::string_view::npos && colon > 0 &&
         std::isalpha(static_cast<unsigned char>(uri[0])) != 0 &&
         std::all_of(uri.begin(), uri.begin() + static_cast<std::ptrdiff_t>(colon), [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '+' || c == '-' || c == '.';
         });
}

std::string decode_base64(std::string_view text) {
  static constexpr auto values = [] {
    std::array<signed char, 256> table{};
    table.fill(-1);
    const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (std::size_t k = 0; k < digits.size(); ++k)
      table[static_cast<unsigned char>(digits[k])] = static_cast<signed char>(k);
    table['-'] = 62;  // the alphabet for URLs
    table['_'] = 63;
    return table;
  }();
  while (!text.empty() && (text.back() == '=' || std::isspace(static_cast<unsigned char>(text.back())) != 0))
    text.remove_suffix(1);
  std::string out;
  out.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int have = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const int value = values[static_cast<unsigned char>(text[at])];
    if (value < 0 && std::isspace(static_cast<unsigned char>(text[at])) != 0) continue;  // of broken lines
    if (value < 0)
      throw ItemError(Status::unreadable,
                      fmt::format("a data URI is not base64 (wrong at character {} of its data)", at));
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    have += 6;
    if (have < 8) continue;
    have -= 8;
    out += static_cast<char>(bits >> have & 0xFF);
  }
  return out;
}

template <class Use>
decltype(auto) with_component(GltfComponent component, Use use) {
  switch (component) {
    case GltfComponent::int8:
      return use(std::int8_t{});
    case GltfComponent::uint8:
      return use(std::uint8_t{});
    case GltfComponent::int16:
      return use(std::int16_t{});
    case GltfComponent::uint16:
      return use(std::uint16_t{});
    case GltfComponent::uint32:
      return use(std::uint32_t{});
    case GltfComponent::float32:
      break;
  }
  return use(float{});
}

}  // namespace

bool is_data_uri(std::string_view uri) { return text::same_word(uri.substr(0, 5), "data:"); }

std::string companion_path(std::string_view uri, std::string& reason) {
  if (has_scheme(uri)) {
    reason = "is not a file of the model's folder";
    return {};
  }
  return path_from_model(percent_decoded(uri), reason);
}

std::string path_from_model(std::string_view path, std::string& reason) {
  std::vector<std::string_view> names;
  std::size_t climb = 0;
  bool names_file = false;
  const bool is_none =
      path.empty() || path[0] == '/' || path[0] == '\\' || path.find('\0') != std::string_view::npos;
  for (std::size_t begin = 0; begin <= path.size() && !is_none;) {
    const std::size_t end = std::min(path.find_first_of("/\\", begin), path.size());
    const std::string_view name = path.substr(begin, end - begin);
    begin = end + 1;
    names_file = !name.empty() && name != "." && name != "..";
    if (names_file)
      names.push_back(name);
    else if (name == ".." && names.empty())
      ++climb;
    else if (name == "..")
      names.pop_back();
  }
  if (!names_file) {
    reason = "is not a path from the model's folder";
    return {};
  }
  std::string kept;
  for (; climb > 0; --climb) kept += "../";
  for (const std::string_view name : names) kept += std::string(name) + "/";
  kept.pop_back();
  return kept;
}

std::string decode_data_uri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) throw ItemError(Status::unreadable, "a data URI without data");
  const std::string_view data = uri.substr(comma + 1);
  constexpr std::string_view mark = ";base64";
  const std::string_view head = uri.substr(0, comma);
  const bool is_base64 =
      head.size() >= mark.size() && text::same_word(head.substr(head.size() - mark.size()), mark);
  if (!is_base64) return percent_decoded(data);
  return data.find('%') == std::string_view::npos ? decode_base64(data)
                                                  : decode_base64(percent_decoded(data));
}

GltfData::GltfData(const GltfDocument& document, std::optional<std::string_view> binary,
                   std::span<const CompanionFile> companions)
    : document_(document),
      binary_(binary),
      companions_(companions),
      buffers_(document.buffer_uris.size()),
      decoded_(document.buffer_uris.size()),
      views_(document.views.size()) {}

std::optional<std::string_view> GltfData::file_of(std::string_view uri, std::string& reason) const {
  const std::string path = companion_path(uri, reason);
  const std::string shown = "`" + shown_text(uri, 200) + "`";
  if (path.empty()) {
    reason = shown + " " + reason;
    return std::nullopt;
  }
  for (const CompanionFile& file : companions_) {
    if (file.path != path) continue;
    if (file.problem.empty()) return text_of(file.bytes);
    // The same for a folder and an archive, whatever the system says.
    using Loss = CompanionFile::Loss;
    reason = shown + (file.loss == Loss::missing   ? " is not there"
                      : file.loss == Loss::outside ? " " + file.problem
                                                   : " cannot be read: " + file.problem);
    return std::nullopt;
  }
  reason = shown + " is not there";
  return std::nullopt;
}

void GltfData::note_missing_buffers(Notes& notes) const {
  for (std::uint32_t number = 0; number < buffers_.size(); ++number) {
    const std::optional<std::string_view>& uri = document_.buffer_uris[number];
    std::string reason;
    if (uri && !is_data_uri(*uri) && !buffers_[number] && !file_of(*uri, reason))
      notes.add(Note::buffer_missing, shown_text(reason, Notes::longest_note_example));
  }
}

std::string_view GltfData::buffer(std::uint32_t number) {
  if (number >= buffers_.size())
    throw ItemError(Status::unreadable, fmt::format("there is no buffer {}", number));
  if (!buffers_[number]) buffers_[number] = find_buffer(number);
  return *buffers_[number];
}

std::string_view GltfData::find_buffer(std::uint32_t number) {
  const std::optional<std::string_view>& uri = document_.buffer_uris[number];
  if (!uri) {
    if (number != 0 || !binary_) fail_in("buffers", number, "it has neither a file nor a binary chunk");
    return *binary_;
  }
  if (!is_data_uri(*uri)) {
    std::string reason;
    const std::optional<std::string_view> bytes = file_of(*uri, reason);
    if (!bytes) fail_in("buffers", number, "its file " + reason);
    return *bytes;
  }
  decoded_[number] = decode_data_uri(*uri);
  return *decoded_[number];
}

std::string_view GltfData::unpacked(std::uint32_t number, const GltfView& view, std::string_view stream) {
  using Packing = GltfView::Packing;
  using Filter = GltfView::Filter;
  if (views_[number]) return *views_[number];
  std::string out(static_cast<std::size_t>(view.count * view.stride), '\0');
  const auto* from = reinterpret_cast<const unsigned char*>(stream.data());
  const auto count = static_cast<std::size_t>(view.count), stride = static_cast<std::size_t>(view.stride);
  const int failed = view.packing == Packing::attributes
                         ? meshopt_decodeVertexBuffer(out.data(), count, stride, from, stream.size())
                     : view.packing == Packing::triangles
                         ? meshopt_decodeIndexBuffer(out.data(), count, stride, from, stream.size())
                         : meshopt_decodeIndexSequence(out.data(), count, stride, from, stream.size());
  if (failed != 0) fail_in("bufferViews", number, "its compressed data are damaged");
  if (view.packing == Packing::attributes) {
    if (view.filter == Filter::octahedral) meshopt_decodeFilterOct(out.data(), count, stride);
    if (view.filter == Filter::quaternion) meshopt_decodeFilterQuat(out.data(), count, stride);
    if (view.filter == Filter::exponential) meshopt_decodeFilterExp(out.data(), count, stride);
  }
  views_[number] = std::move(out);
  return *views_[number];
}

std::string_view GltfData::view(std::uint32_t number) {
  if (number >= document_.views.size())
    throw ItemError(Status::unreadable, fmt::format("there is no buffer view {}", number));
  const GltfView& view = document_.views[number];
  const std::string_view all = buffer(view.buffer);
  if (view.offset > all.size() || view.bytes > all.size() - view.offset)
    fail_in("bufferViews", number,
            fmt::format("bytes {} to {} of a buffer that has {}", view.offset, view.offset + view.bytes,
                        all.size()));
  const std::string_view bytes =
      all.substr(static_cast<std::size_t>(view.offset), static_cast<std::size_t>(view.bytes));
  return view.packing == GltfView::Packing::none ? bytes : unpacked(number, view, bytes);
}

std::string_view GltfData::part(std::uint32_t view_number, std::uint64_t offset, std::uint64_t count,
                                std::uint64_t bytes, std::uint64_t& stride) {
  const std::string_view all = view(view_number);
  if (stride == 0) stride = bytes;
  // Counts are below 2^32 and strides below 2^16.
  if (count > 0 && (offset > all.size() || (count - 1) * stride + bytes > all.size() - offset))
    fail_in("bufferViews", view_number,
            fmt::format("{} elements of {} bytes, {} apart, from byte {}, do not fit into its {} bytes",
                        count, bytes, stride, offset, all.size()));
  return count == 0 ? std::string_view() : all.substr(static_cast<std::size_t>(offset));
}

template <class T, class Convert>
std::vector<T> GltfData::elements(std::uint32_t number, std::uint32_t width, const CancelToken& cancel,
                                  Convert convert) {
  if (number >= document_.accessors.size())
    throw ItemError(Status::unreadable, fmt::format("there is no accessor {}", number));
  const GltfAccessor& accessor = document_.accessors[number];
  if (accessor.width != width)
    fail_in("accessors", number, fmt::format("its elements are not of {} numbers", width));
  const std::uint64_t bytes = bytes_of(accessor.component) * width;
  std::uint64_t stride = accessor.view < document_.views.size() ? document_.views[accessor.view].stride : 0;
  std::string_view from;
  if (accessor.view != no_index) from = part(accessor.view, accessor.offset, accessor.count, bytes, stride);
  std::vector<T> values(static_cast<std::size_t>(accessor.count) * width, T{0});
  const auto copy = [&](std::string_view source, std::uint64_t step, std::uint64_t count, auto place) {
    with_component(accessor.component, [&](auto type) {
      for (std::uint64_t i = 0; i < count; ++i) {
        if (i % elements_between_checks == 0) cancel.check();
        T* const to = values.data() + place(i) * width;
        const char* const at = source.data() + i * step;
        for (std::size_t k = 0; k < width; ++k)
          to[k] = convert(load<decltype(type)>(at + k * sizeof type, is_big_endian), accessor.normalized);
      }
    });
  };
  if (accessor.view != no_index) copy(from, stride, accessor.count, [](std::uint64_t i) { return i; });
  if (accessor.sparse_count == 0) return values;
  std::uint64_t number_stride = bytes_of(accessor.sparse_component), value_stride = bytes;
  const std::string_view places = part(accessor.sparse_numbers, accessor.sparse_numbers_offset,
                                       accessor.sparse_count, number_stride, number_stride);
  const std::string_view changed =
      part(accessor.sparse_values, accessor.sparse_values_offset, accessor.sparse_count, bytes, value_stride);
  copy(changed, value_stride, accessor.sparse_count, [&](std::uint64_t i) {
    const std::uint64_t place = with_component(accessor.sparse_component, [&](auto type) {
      return static_cast<std::uint64_t>(
          load<decltype(type)>(places.data() + i * number_stride, is_big_endian));
    });
    if (place >= accessor.count)
      fail_in("accessors", number,
              fmt::format("the sparse element {} is none of its {}", place, accessor.count));
    return place;
  });
  return values;
}

std::vector<double> GltfData::numbers(std::uint32_t accessor, std::uint32_t width,
                                      const CancelToken& cancel) {
  return elements<double>(accessor, width, cancel, [](auto value, bool normalized) {
    using Value = decltype(value);
    if constexpr (std::is_integral_v<Value>)
      if (normalized) return std::max(value / static_cast<double>(std::numeric_limits<Value>::max()), -1.0);
    return static_cast<double>(value);
  });
}

std::vector<std::uint32_t> GltfData::indices(std::uint32_t accessor, const CancelToken& cancel) {
  return elements<std::uint32_t>(accessor, 1, cancel,
                                 [](auto value, bool) { return static_cast<std::uint32_t>(value); });
}

}  // namespace meander
