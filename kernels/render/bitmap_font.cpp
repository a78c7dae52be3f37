#include "kernels/render/bitmap_font.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace meander {

namespace {

// Seven rows from top to bottom per glyph; the five low bits of a row are its pixels, the highest of them
// leftmost. From the space (32) to the tilde (126), then the box.
// clang-format off
constexpr std::array<std::array<std::uint8_t, 7>, 96> glyphs = {{
    {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00},  // space
    {0x04, 0x04, 0x04, 0x04, 0x04, 0x00, 0x04},  // !
    {0x0A, 0x0A, 0x0A, 0x00, 0x00, 0x00, 0x00},  // "
    {0x0A, 0x0A, 0x1F, 0x0A, 0x1F, 0x0A, 0x0A},  // #
    {0x04, 0x0F, 0x14, 0x0E, 0x05, 0x1E, 0x04},  // $
    {0x18, 0x19, 0x02, 0x04, 0x08, 0x13, 0x03},  // %
    {0x0C, 0x12, 0x14, 0x08, 0x15, 0x12, 0x0D},  // &
    {0x04, 0x04, 0x08, 0x00, 0x00, 0x00, 0x00},  // '
    {0x02, 0x04, 0x08, 0x08, 0x08, 0x04, 0x02},  // (
    {0x08, 0x04, 0x02, 0x02, 0x02, 0x04, 0x08},  // )
    {0x00, 0x04, 0x15, 0x0E, 0x15, 0x04, 0x00},  // *
    {0x00, 0x04, 0x04, 0x1F, 0x04, 0x04, 0x00},  // +
    {0x00, 0x00, 0x00, 0x00, 0x0C, 0x04, 0x08},  // ,
    {0x00, 0x00, 0x00, 0x0E, 0x00, 0x00, 0x00},  // -
    {0x00, 0x00, 0x00, 0x00, 0x00, 0x0C, 0x0C},  // .
    {0x00, 0x01, 0x02, 0x04, 0x08, 0x10, 0x00},  // /
    {0x0E, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0E},  // 0
    {0x04, 0x0C, 0x04, 0x04, 0x04, 0x04, 0x0E},  // 1
    {0x0E, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1F},  // 2
    {0x1F, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0E},  // 3
    {0x02, 0x06, 0x0A, 0x12, 0x1F, 0x02, 0x02},  // 4
    {0x1F, 0x10, 0x1E, 0x01, 0x01, 0x11, 0x0E},  // 5
    {0x06, 0x08, 0x10, 0x1E, 0x11, 0x11, 0x0E},  // 6
    {0x1F, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08},  // 7
    {0x0E, 0x11, 0x11, 0x0E, 0x11, 0x11, 0x0E},  // 8
    {0x0E, 0x11, 0x11, 0x0F, 0x01, 0x02, 0x0C},  // 9
    {0x00, 0x0C, 0x0C, 0x00, 0x0C, 0x0C, 0x00},  // :
    {0x00, 0x0C, 0x0C, 0x00, 0x0C, 0x04, 0x08},  // ;
    {0x02, 0x04, 0x08, 0x10, 0x08, 0x04, 0x02},  // <
    {0x00, 0x00, 0x1F, 0x00, 0x1F, 0x00, 0x00},  // =
    {0x08, 0x04, 0x02, 0x01, 0x02, 0x04, 0x08},  // >
    {0x0E, 0x11, 0x01, 0x02, 0x04, 0x00, 0x04},  // ?
    {0x0E, 0x11, 0x17, 0x15, 0x17, 0x10, 0x0F},  // @
    {0x0E, 0x11, 0x11, 0x1F, 0x11, 0x11, 0x11},  // A
    {0x1E, 0x11, 0x11, 0x1E, 0x11, 0x11, 0x1E},  // B
    {0x0E, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0E},  // C
    {0x1C, 0x12, 0x11, 0x11, 0x11, 0x12, 0x1C},  // D
    {0x1F, 0x10, 0x10, 0x1E, 0x10, 0x10, 0x1F},  // E
    {0x1F, 0x10, 0x10, 0x1E, 0x10, 0x10, 0x10},  // F
    {0x0E, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0F},  // G
    {0x11, 0x11, 0x11, 0x1F, 0x11, 0x11, 0x11},  // H
    {0x0E, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0E},  // I
    {0x07, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0C},  // J
    {0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11},  // K
    {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1F},  // L
    {0x11, 0x1B, 0x15, 0x15, 0x11, 0x11, 0x11},  // M
    {0x11, 0x11, 0x19, 0x15, 0x13, 0x11, 0x11},  // N
    {0x0E, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0E},  // O
    {0x1E, 0x11, 0x11, 0x1E, 0x10, 0x10, 0x10},  // P
    {0x0E, 0x11, 0x11, 0x11, 0x15, 0x12, 0x0D},  // Q
    {0x1E, 0x11, 0x11, 0x1E, 0x14, 0x12, 0x11},  // R
    {0x0F, 0x10, 0x10, 0x0E, 0x01, 0x01, 0x1E},  // S
    {0x1F, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04},  // T
    {0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0E},  // U
    {0x11, 0x11, 0x11, 0x11, 0x11, 0x0A, 0x04},  // V
    {0x11, 0x11, 0x11, 0x15, 0x15, 0x15, 0x0A},  // W
    {0x11, 0x11, 0x0A, 0x04, 0x0A, 0x11, 0x11},  // X
    {0x11, 0x11, 0x11, 0x0A, 0x04, 0x04, 0x04},  // Y
    {0x1F, 0x01, 0x02, 0x04, 0x08, 0x10, 0x1F},  // Z
    {0x0E, 0x08, 0x08, 0x08, 0x08, 0x08, 0x0E},  // [
    {0x00, 0x10, 0x08, 0x04, 0x02, 0x01, 0x00},  // backslash
    {0x0E, 0x02, 0x02, 0x02, 0x02, 0x02, 0x0E},  // ]
    {0x04, 0x0A, 0x11, 0x00, 0x00, 0x00, 0x00},  // ^
    {0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x1F},  // _
    {0x08, 0x04, 0x02, 0x00, 0x00, 0x00, 0x00},  // `
    {0x00, 0x00, 0x0E, 0x01, 0x0F, 0x11, 0x0F},  // a
    {0x10, 0x10, 0x16, 0x19, 0x11, 0x11, 0x1E},  // b
    {0x00, 0x00, 0x0E, 0x10, 0x10, 0x11, 0x0E},  // c
    {0x01, 0x01, 0x0D, 0x13, 0x11, 0x11, 0x0F},  // d
    {0x00, 0x00, 0x0E, 0x11, 0x1F, 0x10, 0x0E},  // e
    {0x06, 0x09, 0x08, 0x1C, 0x08, 0x08, 0x08},  // f
    {0x00, 0x00, 0x0F, 0x11, 0x0F, 0x01, 0x0E},  // g
    {0x10, 0x10, 0x16, 0x19, 0x11, 0x11, 0x11},  // h
    {0x04, 0x00, 0x0C, 0x04, 0x04, 0x04, 0x0E},  // i
    {0x02, 0x00, 0x06, 0x02, 0x02, 0x12, 0x0C},  // j
    {0x10, 0x10, 0x12, 0x14, 0x18, 0x14, 0x12},  // k
    {0x0C, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0E},  // l
    {0x00, 0x00, 0x1A, 0x15, 0x15, 0x11, 0x11},  // m
    {0x00, 0x00, 0x16, 0x19, 0x11, 0x11, 0x11},  // n
    {0x00, 0x00, 0x0E, 0x11, 0x11, 0x11, 0x0E},  // o
    {0x00, 0x00, 0x1E, 0x11, 0x1E, 0x10, 0x10},  // p
    {0x00, 0x00, 0x0D, 0x13, 0x0F, 0x01, 0x01},  // q
    {0x00, 0x00, 0x16, 0x19, 0x10, 0x10, 0x10},  // r
    {0x00, 0x00, 0x0E, 0x10, 0x0E, 0x01, 0x1E},  // s
    {0x08, 0x08, 0x1C, 0x08, 0x08, 0x09, 0x06},  // t
    {0x00, 0x00, 0x11, 0x11, 0x11, 0x13, 0x0D},  // u
    {0x00, 0x00, 0x11, 0x11, 0x11, 0x0A, 0x04},  // v
    {0x00, 0x00, 0x11, 0x11, 0x15, 0x15, 0x0A},  // w
    {0x00, 0x00, 0x11, 0x0A, 0x04, 0x0A, 0x11},  // x
    {0x00, 0x00, 0x11, 0x11, 0x0F, 0x01, 0x0E},  // y
    {0x00, 0x00, 0x1F, 0x02, 0x04, 0x08, 0x1F},  // z
    {0x06, 0x08, 0x08, 0x10, 0x08, 0x08, 0x06},  // {
    {0x04, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04},  // |
    {0x0C, 0x02, 0x02, 0x01, 0x02, 0x02, 0x0C},  // }
    {0x00, 0x00, 0x08, 0x15, 0x02, 0x00, 0x00},  // ~
    {0x1F, 0x11, 0x11, 0x11, 0x11, 0x11, 0x1F},  // any other character
}};
// clang-format on

constexpr bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

std::size_t glyph_of(char c) {
  const auto code = static_cast<unsigned char>(c);
  return code >= 32 && code < 127 ? code - 32u : 95u;
}

std::size_t character_count(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

// Bytes of the first `count` characters.
std::size_t bytes_of(std::string_view text, std::size_t count) {
  std::size_t seen = 0, at = 0;
  for (; at < text.size(); ++at)
    if (begins_character(text[at]) && seen++ == count) break;
  return at;
}

// ---- strokes ----

// Where strokes have room for more than the bitmaps: letters that reach below the line, from the third row of
// the others on, and a zero without its bar.
struct TallGlyph {
  char character;
  int first_row;
  std::array<std::uint8_t, 9> rows;
};
constexpr std::array<TallGlyph, 6> tall_glyphs = {{
    {'0', 0, {0x0C, 0x12, 0x12, 0x12, 0x12, 0x12, 0x0C}},
    {'g', 2, {0x0F, 0x11, 0x11, 0x11, 0x0F, 0x01, 0x0E}},
    {'j', 0, {0x02, 0x00, 0x06, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0C}},
    {'p', 2, {0x1E, 0x11, 0x11, 0x11, 0x1E, 0x10, 0x10}},
    {'q', 2, {0x0F, 0x11, 0x11, 0x11, 0x0F, 0x01, 0x01}},
    {'y', 2, {0x11, 0x11, 0x11, 0x11, 0x0F, 0x01, 0x0E}},
}};
constexpr int columns = static_cast<int>(glyph_width), tall_height = 9;
using GlyphCells = std::array<std::array<bool, glyph_width>, tall_height>;

GlyphCells cells_of(char c) {
  GlyphCells cells{};
  const auto fill = [&](int first_row, const auto& rows) {
    for (std::size_t r = 0; r < rows.size() && first_row + static_cast<int>(r) < tall_height; ++r)
      for (int column = 0; column < columns; ++column)
        cells[static_cast<std::size_t>(first_row) + r][static_cast<std::size_t>(column)] =
            (rows[r] >> (columns - 1 - column) & 1) != 0;
  };
  const auto tall = std::find_if(tall_glyphs.begin(), tall_glyphs.end(),
                                 [c](const TallGlyph& g) { return g.character == c; });
  if (tall != tall_glyphs.end())
    fill(tall->first_row, tall->rows);
  else
    fill(0, glyphs[glyph_of(c)]);
  return cells;
}

struct FontPoint {
  double x, y;  // in pixels of the font
};
using Stroke = std::vector<FontPoint>;

// Corners cut off (Chaikin 1974); the ends stay.
Stroke rounded(Stroke line, bool closed) {
  for (int pass = 0; pass < 3 && line.size() > 2; ++pass) {
    Stroke finer;
    if (!closed) finer.push_back(line.front());
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
      for (const double share : {0.25, 0.75})
        finer.push_back({line[i].x + share * (line[i + 1].x - line[i].x),
                         line[i].y + share * (line[i + 1].y - line[i].y)});
    finer.push_back(closed ? finer.front() : line.back());
    line = std::move(finer);
  }
  return line;
}

// The cells of a glyph and what joins them: with those beside, below and, where there is no way around,
// diagonally below.
struct GlyphGraph {
  std::vector<FontPoint> nodes;
  std::vector<std::vector<std::size_t>> joined;
  std::vector<std::uint8_t> is_end;  // of strokes: all but those that two joints pass

  explicit GlyphGraph(const GlyphCells& cells) {
    std::array<std::array<std::size_t, glyph_width>, tall_height> number{};
    const auto set = [&](int column, int row) {
      return column >= 0 && column < columns && row < tall_height &&
             cells[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    };
    const auto node = [&](int column, int row) -> std::size_t& {
      return number[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
    };
    for (int row = 0; row < tall_height; ++row)
      for (int column = 0; column < columns; ++column)
        if (set(column, row)) {
          node(column, row) = nodes.size();
          nodes.push_back({static_cast<double>(column), static_cast<double>(row)});
        }
    joined.resize(nodes.size());
    const auto join = [&](std::size_t a, std::size_t b) {
      joined[a].push_back(b);
      joined[b].push_back(a);
    };
    for (int row = 0; row < tall_height; ++row)
      for (int column = 0; column < columns; ++column) {
        if (!set(column, row)) continue;
        const std::size_t own = node(column, row);
        if (set(column + 1, row)) join(own, node(column + 1, row));
        if (set(column, row + 1)) join(own, node(column, row + 1));
        for (const int side : {-1, 1})
          if (set(column + side, row + 1) && !set(column + side, row) && !set(column, row + 1))
            join(own, node(column + side, row + 1));
      }
    for (const auto& others : joined) is_end.push_back(others.size() != 2);
  }

  // Follows joints that were not used yet from a node to the next end, branch, or itself.
  Stroke follow(std::size_t from) {
    Stroke line = {nodes[from]};
    const std::size_t start = from;
    while (!joined[from].empty()) {
      const std::size_t next = joined[from].front();
      joined[from].erase(joined[from].begin());
      joined[next].erase(std::find(joined[next].begin(), joined[next].end(), from));
      line.push_back(nodes[next]);
      from = next;
      if (from == start || is_end[from] != 0) break;
    }
    return line;
  }
};

struct StrokeGlyph {
  std::vector<Stroke> strokes;  // the first used column being 0
  double width = 2;             // to the last used column; a space is as wide as this
};

StrokeGlyph strokes_of(char c) {
  GlyphGraph graph(cells_of(c));
  StrokeGlyph glyph;
  if (graph.nodes.empty()) return glyph;
  double first = columns, last = 0;
  for (const FontPoint& p : graph.nodes) {
    first = std::min(first, p.x);
    last = std::max(last, p.x);
  }
  glyph.width = last - first;
  for (FontPoint& p : graph.nodes) p.x -= first;
  for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
    if (graph.is_end[n] == 0) continue;
    if (graph.joined[n].empty()) glyph.strokes.push_back({graph.nodes[n]});
    while (!graph.joined[n].empty()) glyph.strokes.push_back(rounded(graph.follow(n), false));
  }
  for (std::size_t n = 0; n < graph.nodes.size(); ++n)
    if (!graph.joined[n].empty()) glyph.strokes.push_back(rounded(graph.follow(n), true));
  return glyph;
}

constexpr double stroke_gap = 2;  // between the last column of a glyph and the first of the next

double distance_to(const Stroke& line, double x, double y) {
  double nearest = std::hypot(x - line.front().x, y - line.front().y);
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double dx = line[i + 1].x - line[i].x, dy = line[i + 1].y - line[i].y, square = dx * dx + dy * dy;
    const double t =
        square > 0 ? std::clamp(((x - line[i].x) * dx + (y - line[i].y) * dy) / square, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, std::hypot(x - line[i].x - t * dx, y - line[i].y - t * dy));
  }
  return nearest;
}

}  // namespace

double smooth_text_width(std::string_view text, double size) {
  double width = 0;
  for (const char c : text)
    if (begins_character(c)) width += strokes_of(c).width + stroke_gap;
  return size * std::max(0.0, width - stroke_gap);
}

void draw_smooth_text(RgbImage& image, std::string_view text, double x, double y, double size,
                      std::array<std::uint8_t, 3> colour) {
  const double pen = std::max(0.5, 0.42 * size);
  for (const char c : text) {
    if (!begins_character(c)) continue;
    const StrokeGlyph glyph = strokes_of(c);
    const auto first_x = static_cast<std::int64_t>(std::floor(x - size)),
               last_x = static_cast<std::int64_t>(std::ceil(x + size * (glyph.width + 1))),
               first_y = static_cast<std::int64_t>(std::floor(y - size)),
               last_y = static_cast<std::int64_t>(std::ceil(y + size * tall_height));
    for (std::int64_t py = std::max<std::int64_t>(0, first_y); py <= last_y && py < image.height; ++py)
      for (std::int64_t px = std::max<std::int64_t>(0, first_x); px <= last_x && px < image.width; ++px) {
        double nearest = 1e9;
        for (const Stroke& stroke : glyph.strokes)
          nearest = std::min(nearest, distance_to(stroke, (static_cast<double>(px) - x) / size,
                                                  (static_cast<double>(py) - y) / size));
        const double ink = std::clamp(pen + 0.5 - size * nearest, 0.0, 1.0);
        if (!(ink > 0)) continue;
        std::uint8_t* pixel = image.pixel(static_cast<std::uint32_t>(px), static_cast<std::uint32_t>(py));
        for (std::size_t k = 0; k < 3; ++k)
          pixel[k] = static_cast<std::uint8_t>(std::lround(pixel[k] + ink * (colour[k] - pixel[k])));
      }
    x += size * (glyph.width + stroke_gap);
  }
}

std::uint32_t text_width(std::string_view text) {
  const auto count = static_cast<std::uint32_t>(character_count(text));
  return count == 0 ? 0 : count * glyph_advance - (glyph_advance - glyph_width);
}

std::string shortened_text(std::string_view text, std::uint32_t width) {
  const std::size_t fits = (width + glyph_advance - glyph_width) / glyph_advance;
  const std::size_t count = character_count(text);
  if (count <= fits) return std::string(text);
  if (fits <= 2) return std::string(fits, '.');
  // The end of a name distinguishes models of one folder better than its beginning.
  const std::size_t head = (fits - 2) / 2, tail = fits - 2 - head;
  return std::string(text.substr(0, bytes_of(text, head))) + ".." +
         std::string(text.substr(bytes_of(text, count - tail)));
}

void draw_text(RgbImage& image, std::string_view text, std::int64_t x, std::int64_t y, std::uint32_t scale,
               std::uint8_t grey) {
  for (const char c : text) {
    if (!begins_character(c)) continue;
    const auto& rows = glyphs[glyph_of(c)];
    for (std::uint32_t row = 0; row < glyph_height * scale; ++row)
      for (std::uint32_t column = 0; column < glyph_width * scale; ++column) {
        if ((rows[row / scale] >> (glyph_width - 1 - column / scale) & 1) == 0) continue;
        const std::int64_t px = x + column, py = y + row;
        if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
        std::uint8_t* pixel = image.pixel(static_cast<std::uint32_t>(px), static_cast<std::uint32_t>(py));
        std::fill(pixel, pixel + 3, grey);
      }
    x += glyph_advance * scale;
  }
}

}  // namespace meander
