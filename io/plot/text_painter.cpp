#include "io/plot/text_painter.h"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>

#include "io/utf8.h"

namespace meander {

namespace {

constexpr std::string_view ellipsis = "\xE2\x80\xA6";

struct Free {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* context) const { cairo_destroy(context); }
};
using Surface = std::unique_ptr<cairo_surface_t, Free>;
using Context = std::unique_ptr<cairo_t, Free>;

void check(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS)
    throw std::runtime_error(std::string("text cannot be drawn: ") + cairo_status_to_string(status));
}

// A mask of coverage, with the font of the style selected.
struct Mask {
  Surface surface;
  Context context;

  Mask(int width, int height, const TextStyle& style)
      : surface(cairo_image_surface_create(CAIRO_FORMAT_A8, width, height)),
        context(cairo_create(surface.get())) {
    cairo_select_font_face(context.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                           style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(context.get(), style.size);
    cairo_font_options_t* const options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(context.get(), options);
    cairo_font_options_destroy(options);
    check(cairo_status(context.get()));
  }
};

// cairo refuses texts that are not UTF-8, and text ends at a zero byte.
std::string clean(std::string_view text) {
  std::string clean;
  while (!text.empty()) {
    const std::size_t length = utf8_sequence_length(text);
    const bool is_control = length == 1 && static_cast<unsigned char>(text[0]) < 0x20;
    clean += length == 0 ? "?" : is_control ? " " : text.substr(0, length);
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return clean;
}

double advance(const Mask& mask, const std::string& text) {
  cairo_text_extents_t extents;
  cairo_text_extents(mask.context.get(), text.c_str(), &extents);
  check(cairo_status(mask.context.get()));
  return extents.x_advance;
}

void mix(std::uint8_t* pixel, const Rgb& color, unsigned coverage) {
  const std::uint8_t own[3] = {color.red, color.green, color.blue};
  for (int k = 0; k < 3; ++k)
    pixel[k] = static_cast<std::uint8_t>((pixel[k] * (255 - coverage) + own[k] * coverage + 127) / 255);
}

}  // namespace

double painted_width(std::string_view text, const TextStyle& style) {
  return advance(Mask(1, 1, style), clean(text));
}

void paint_text(RgbImage& image, std::string_view text, double x, double baseline, const TextStyle& style,
                TextAlign align) {
  const std::string words = clean(text);
  const double width = painted_width(words, style);
  const double left = align == TextAlign::left ? x : align == TextAlign::center ? x - 0.5 * width : x - width;
  // Glyphs may reach beyond their advance, and above and below the em.
  const double margin = style.size;
  const double begin = std::floor(left - margin), top = std::floor(baseline - 2 * margin);
  const int columns = static_cast<int>(std::ceil(width + 2 * margin)) + 2;
  const int rows = static_cast<int>(std::ceil(3 * margin)) + 2;
  const Mask mask(columns, rows, style);
  cairo_move_to(mask.context.get(), left - begin, baseline - top);
  cairo_show_text(mask.context.get(), words.c_str());
  check(cairo_status(mask.context.get()));
  cairo_surface_flush(mask.surface.get());
  const std::uint8_t* const coverage = cairo_image_surface_get_data(mask.surface.get());
  const int stride = cairo_image_surface_get_stride(mask.surface.get());
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double at_x = begin + column, at_y = top + row;
      if (at_x < 0 || at_y < 0 || at_x >= image.width || at_y >= image.height) continue;
      const unsigned covered = coverage[static_cast<std::ptrdiff_t>(row) * stride + column];
      if (covered > 0)
        mix(image.pixel(static_cast<std::uint32_t>(at_x), static_cast<std::uint32_t>(at_y)), style.color,
            covered);
    }
}

std::string shortened_at_front(std::string_view text, double width, const TextStyle& style) {
  const Mask mask(1, 1, style);
  std::string words = clean(text);
  if (advance(mask, words) <= width) return words;
  std::string_view rest = words;
  while (!rest.empty()) {
    rest.remove_prefix(std::max<std::size_t>(utf8_sequence_length(rest), 1));
    std::string shorter = std::string(ellipsis) + std::string(rest);
    if (advance(mask, shorter) <= width) return shorter;
  }
  return std::string(ellipsis);
}

std::vector<std::string> wrapped_text(std::string_view text, double width, std::size_t most,
                                      const TextStyle& style) {
  const Mask mask(1, 1, style);
  const std::string words = clean(text);
  std::vector<std::string> lines(1);
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find(' ', begin), words.size());
    const std::string word = words.substr(begin, end - begin);
    begin = end + 1;
    if (word.empty()) continue;
    const std::string longer = lines.back().empty() ? word : lines.back() + " " + word;
    if (lines.back().empty() || advance(mask, longer) <= width) {
      lines.back() = longer;
    } else if (lines.size() < most) {
      lines.push_back(word);
    } else {
      std::string& last = lines.back();
      while (advance(mask, last + std::string(ellipsis)) > width && last.find(' ') != std::string::npos)
        last.resize(last.rfind(' '));
      last += ellipsis;
      break;
    }
  }
  for (std::string& line : lines)
    if (advance(mask, line) > width) line = shortened_at_front(line, width, style);
  return lines;
}

}  // namespace meander
