// PLY: ascii and binary of either byte order, with any elements and properties.
#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io/mesh/format_readers.h"
#include "io/mesh/line_blocks.h"
#include "io/mesh/mtl_reader.h"
#include "io/mesh/ply_rows.h"
#include "io/mesh/text_cursor.h"
#include "io/mesh/texture_images.h"

namespace meander {

namespace {

using text::TextCursor;
using text::Token;

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

// What an element's rows are to a mesh. Only the first element of a name counts.
// Materials only where colors are asked for.
enum class Role : std::uint8_t { other, vertices, faces, strips, materials };

class PlyMeshReader {
 public:
  PlyMeshReader(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                const MeshSurroundings& around)
      : content_(content),
        cancel_(cancel),
        rule_(rule),
        around_(around),
        header_(parse_ply_header(content)),
        textured_(around.colors && !header_.texture_files.empty()),
        wants_coordinates_(textured_ || around.extras.coordinates) {
    std::array<bool, 5> taken{};  // by role
    for (const PlyElement& element : header_.elements) {
      Role role = element.name == "vertex"                       ? Role::vertices
                  : element.name == "face"                       ? Role::faces
                  : element.name == "tristrips"                  ? Role::strips
                  : around_.colors && element.name == "material" ? Role::materials
                                                                 : Role::other;
      if (std::exchange(taken[static_cast<std::size_t>(role)], true)) role = Role::other;
      roles_.push_back(role);
    }
  }

  PolygonMesh read() {
    check_header();
    const std::string_view body = content_.substr(header_.body);
    const bool ascii = header_.encoding == PlyEncoding::ascii;
    if (!ascii)
      read_binary(body);
    else if (body.size() < rule_.parallel_from || wants_wedges() || !read_lines(body))
      read_ascii(body);
    finish();
    if (around_.colors) {
      mesh_.colors.vertex = colors_of("vertex", mesh_.vertex_attributes, mesh_.vertex_count());
      mesh_.colors.face = colors_of("face", mesh_.face_attributes, mesh_.polygon_count());
      if (mesh_.colors.face.empty()) mesh_.colors.face = colors_of_materials();
    }
    if (wants_coordinates_) {
      CornerCoordinates coordinates = corner_coordinates();
      const bool keeps = around_.extras.coordinates && !coordinates.values.empty();
      if (keeps && textured_) mesh_.coordinates = coordinates;
      if (textured_)
        add_textures(std::move(coordinates));
      else if (keeps)
        mesh_.coordinates = std::move(coordinates);
    }
    return std::move(mesh_);
  }

 private:
  void check_header() const {
    std::uint64_t promised = 0;
    for (std::size_t e = 0; e < roles_.size(); ++e) {
      if (roles_[e] != Role::faces && roles_[e] != Role::strips) continue;
      const PlyElement& element = header_.elements[e];
      promised = std::max(promised, element.count);
      if (element.count > 0 && element.index_list() < 0)
        throw ItemError(Status::unreadable, "the element " + element.name + " has no list vertex_indices");
    }
    const PlyElement* const vertices = header_.find("vertex");
    if (promised == 0)
      throw ItemError(Status::empty, "the header promises " + std::to_string(vertices ? vertices->count : 0) +
                                         " vertices and no face");
    if (vertices == nullptr) throw ItemError(Status::unreadable, "the header has no element vertex");
    check_positions(*vertices);
  }

  // The colors of an element with three properties of these names, which its attributes hold already.
  std::vector<float> colors_of(std::string_view element_name, const std::vector<ScalarAttribute>& attributes,
                               std::size_t count) const {
    static constexpr std::array<std::array<std::string_view, 3>, 3> known = {
        {{"red", "green", "blue"}, {"diffuse_red", "diffuse_green", "diffuse_blue"}, {"r", "g", "b"}}};
    const PlyElement* const element = header_.find(element_name);
    if (element == nullptr) return {};
    for (const std::array<std::string_view, 3>& names : known) {
      std::vector<float> colors(3 * count);
      bool is_whole = true;
      ColorNumbers numbers = ColorNumbers::whole;
      for (std::size_t c = 0; c < 3; ++c) {
        const int property = element->scalar_named(names[c]);
        const std::string_view name =
            property < 0 ? names[c] : element->properties[static_cast<std::size_t>(property)].name;
        const auto attribute = std::find_if(attributes.begin(), attributes.end(),
                                            [&](const ScalarAttribute& a) { return a.name == name; });
        is_whole = property >= 0 && attribute != attributes.end() && attribute->values.size() == count;
        if (!is_whole) break;
        const PlyType type = element->properties[static_cast<std::size_t>(property)].type;
        if (type == PlyType::float32 || type == PlyType::float64) numbers = ColorNumbers::real;
        // Programs that have no unsigned bytes write 200 as -56.
        const bool wraps = type == PlyType::int8;
        for (std::size_t i = 0; i < count; ++i) {
          const double value = attribute->values[i];
          colors[3 * i + c] = static_cast<float>(wraps && value < 0 ? value + 256 : value);
        }
      }
      if (!is_whole) continue;
      scale_colors(colors, numbers);
      return colors;
    }
    return {};
  }

  // The list of the texture coordinates of the corners of a face, u and v in turn; -1: there is none.
  static int wedge_list(const PlyElement& element) {
    for (std::size_t p = 0; p < element.properties.size(); ++p)
      if (element.properties[p].is_list && element.properties[p].name == "texcoord")
        return static_cast<int>(p);
    return -1;
  }
  bool wants_wedges() const {
    const PlyElement* const faces = header_.find("face");
    return wants_coordinates_ && faces != nullptr && wedge_list(*faces) >= 0;
  }

  static const std::vector<double>* values_of(const std::vector<ScalarAttribute>& attributes,
                                              std::string_view name) {
    for (const ScalarAttribute& attribute : attributes)
      if (attribute.name == name) return &attribute.values;
    return nullptr;
  }

  // Texture coordinates of all corners, of the faces or else of the vertices; none where the file has none.
  CornerCoordinates corner_coordinates() {
    CornerCoordinates coordinates;
    if (wants_wedges()) {
      coordinates.corner.assign(mesh_.corners.size(), no_index);
      coordinates.values = std::move(wedges_.values);
      check_count(coordinates.values.size() / 2, "texture coordinates");
      for (std::size_t p = 0; p + 1 < wedges_.begin.size() && p < mesh_.polygon_count(); ++p) {
        const std::uint32_t begin = mesh_.polygon_begin[p], end = mesh_.polygon_begin[p + 1];
        const std::size_t first = wedges_.begin[p];
        // Lists of an odd length would put all that follow out of step.
        if (wedges_.begin[p + 1] - first != 2 * std::size_t{end - begin} || first % 2 != 0) continue;
        for (std::uint32_t c = begin; c < end; ++c)
          coordinates.corner[c] = static_cast<std::uint32_t>(first / 2 + (c - begin));
      }
      return coordinates;
    }
    static constexpr std::array<std::array<std::string_view, 2>, 4> known = {
        {{"texture_u", "texture_v"}, {"s", "t"}, {"u", "v"}, {"texture_s", "texture_t"}}};
    for (const std::array<std::string_view, 2>& names : known) {
      const std::vector<double>* const u = values_of(mesh_.vertex_attributes, names[0]);
      const std::vector<double>* const v = values_of(mesh_.vertex_attributes, names[1]);
      if (u == nullptr || v == nullptr) continue;
      for (std::size_t i = 0; i < u->size(); ++i)
        for (const double value : {(*u)[i], (*v)[i]}) coordinates.values.push_back(static_cast<float>(value));
      coordinates.corner = mesh_.corners;
      for (std::uint32_t& corner : coordinates.corner)
        if (corner >= u->size()) corner = no_index;
      break;
    }
    return coordinates;
  }

  // The images of the header, on the faces whose corners have coordinates; `texnumber` says which.
  void add_textures(CornerCoordinates coordinates) {
    auto textures = std::make_shared<SurfaceTextures>();
    FileImages images(around_.companions, cancel_, *textures, mesh_.notes);
    for (const std::string& name : header_.texture_files) {
      Texture& texture = textures->textures.emplace_back();
      texture.placement = {1, 0, 0, 0, -1, 1};  // v points up
      texture.image = images.number_of(meant_path({}, name), name);
    }
    const std::vector<double>* const number = values_of(mesh_.face_attributes, "texnumber");
    std::uint64_t textured = 0, unknown = 0;
    for (std::size_t p = 0; p < mesh_.polygon_count(); ++p) {
      const double wanted = number == nullptr ? 0 : (*number)[p];
      const bool is_known = wanted >= 0 && wanted < static_cast<double>(textures->textures.size());
      textures->face.push_back(is_known ? static_cast<std::uint32_t>(wanted) : no_index);
      unknown += !is_known && wanted >= 0;
      textured += is_known;
      // The image says all; the color of a face would be multiplied with it.
      if (is_known && !mesh_.colors.face.empty())
        std::fill_n(mesh_.colors.face.begin() + static_cast<std::ptrdiff_t>(3 * p), 3, no_color);
    }
    const bool has_any = !coordinates.corner.empty();
    if (!has_any) coordinates.corner.assign(mesh_.corners.size(), no_index);
    textures->coordinates = std::move(coordinates.values);
    textures->corner = std::move(coordinates.corner);
    mesh_.notes.add(Note::coordinates_missing, untextured_faces,
                    has_any ? count_lacking_coordinates(mesh_, *textures) : textured);
    mesh_.notes.add(Note::image_missing, "`texnumber` of faces is the number of no image of the header",
                    unknown);
    mesh_.colors.textures = std::move(textures);
  }

  // The colors of faces that have the number of one of the file's materials as `material_index`.
  std::vector<float> colors_of_materials() {
    const auto numbers = std::find_if(mesh_.face_attributes.begin(), mesh_.face_attributes.end(),
                                      [](const ScalarAttribute& a) { return a.name == "material_index"; });
    const std::size_t materials =
        material_attributes_.empty() ? 0 : material_attributes_.front().values.size();
    const std::vector<float> known = colors_of("material", material_attributes_, materials);
    if (known.empty() || numbers == mesh_.face_attributes.end()) return {};
    std::vector<float> colors(3 * mesh_.polygon_count(), no_color);
    std::uint64_t missing = 0;
    for (std::size_t f = 0; f < mesh_.polygon_count(); ++f) {
      const double number = numbers->values[f];
      if (number >= 0 && number < static_cast<double>(materials))
        std::copy_n(known.data() + 3 * static_cast<std::size_t>(number), 3, colors.data() + 3 * f);
      else
        ++missing;
    }
    mesh_.notes.add(Note::material_missing,
                    "faces name none of the file's " + std::to_string(materials) + " materials", missing);
    return colors;
  }

  // Takes memory for `rows` rows of element e and says where its properties go.
  PlyColumns make_columns(std::size_t e, std::uint64_t rows) {
    const PlyElement& element = header_.elements[e];
    PlyColumns columns;
    columns.columns.resize(element.properties.size());
    const Role role = roles_[e];
    if (role == Role::faces || role == Role::strips) columns.index_list = element.index_list();
    if (role == Role::faces && wants_wedges()) {
      columns.number_list = wedge_list(element);
      columns.numbers = &wedges_;
    }
    if (role != Role::vertices && role != Role::faces && role != Role::materials) return columns;
    check_count(rows, role == Role::vertices ? "vertices" : role == Role::faces ? "faces" : "materials");
    if (rows == 0) return columns;
    if (role == Role::vertices)
      place_vertices(element, rows, {&mesh_.x, &mesh_.y, &mesh_.z}, mesh_.normals, columns);
    std::vector<ScalarAttribute>& attributes = attributes_of(role);
    for (std::size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      PlyColumns::Column& target = columns.columns[p];
      if (property.is_list || target.values != nullptr || target.normals != nullptr) continue;
      const bool integers = property.type != PlyType::float32 && property.type != PlyType::float64;
      attributes.push_back({property.name, std::vector<double>(rows, nan_value), integers});
      target.values = attributes.back().values.data();
    }
    return columns;
  }

  std::vector<ScalarAttribute>& attributes_of(Role role) {
    return role == Role::vertices ? mesh_.vertex_attributes
           : role == Role::faces  ? mesh_.face_attributes
                                  : material_attributes_;
  }

  // Cuts the arrays of element e to the rows that are there and counts what is missing.
  void end_element(std::size_t e, std::uint64_t rows) {
    const Role role = roles_[e];
    const std::uint64_t missing = header_.elements[e].count - rows;
    if (missing > 0 && complete_) {
      complete_ = false;
      cut_in_ = "row " + std::to_string(rows) + " of " + std::to_string(header_.elements[e].count) +
                " of the element " + printable(header_.elements[e].name);
    }
    if (role == Role::strips || role == Role::faces)
      mesh_.repairs[Repair::missing_faces] = saturated(mesh_.repairs[Repair::missing_faces] + missing);
    if (role == Role::vertices) {
      mesh_.repairs[Repair::missing_vertices] = saturated(missing);
      for (std::vector<double>* const values : {&mesh_.x, &mesh_.y, &mesh_.z}) values->resize(rows);
      if (!mesh_.normals.empty()) mesh_.normals.resize(3 * rows);
    }
    if (role == Role::vertices || role == Role::faces || role == Role::materials)
      for (ScalarAttribute& attribute : attributes_of(role)) attribute.values.resize(rows);
  }

  static std::string printable(const std::string& name) { return text::quoted(name, name.data()); }

  std::vector<PolygonPart>& parts_of(Role role) { return role == Role::strips ? strips_ : faces_; }

  void read_binary(std::string_view body) {
    std::size_t at = 0;
    for (std::size_t e = 0; e < roles_.size(); ++e) {
      const PlyElement& element = header_.elements[e];
      const std::string_view data = body.substr(at);
      PlyProgress progress;
      if (complete_) {
        const std::uint64_t fit = element.properties.empty() ? 0 : data.size() / element.fixed_bytes();
        const PlyColumns columns = make_columns(e, std::min(element.count, fit));
        std::vector<PolygonPart>& parts = parts_of(roles_[e]);
        parts.resize(1);
        PolygonPart unused;
        progress = read_binary_rows(data, element, header_.swaps_bytes(), columns,
                                    columns.index_list >= 0 ? parts[0] : unused, cancel_, rule_);
      }
      at += progress.bytes;
      end_element(e, progress.rows);
    }
    rest_ = complete_ ? body.substr(at) : std::string_view{};
  }

  // One row of an ascii file. bad: a coordinate is not a number (the cursor is at it). With `repairs` null,
  // whatever would be a repair is bad too.
  Token read_row(TextCursor& cursor, std::size_t e, std::uint64_t row, const PlyColumns& columns,
                 PolygonPart& polygons, RepairCounts* repairs) const {
    const PlyElement& element = header_.elements[e];
    bool given_up = false;
    Token token = Token::ok;
    for (std::size_t p = 0; p < element.properties.size() && token == Token::ok && !given_up; ++p) {
      const bool is_index_list = columns.index_list == static_cast<int>(p);
      if (columns.number_list == static_cast<int>(p)) {
        token = read_numbers(cursor, *columns.numbers);
        // As a list of corners: what stands behind it cannot be told apart.
        given_up = token == Token::bad;
        if (given_up && repairs != nullptr) token = Token::ok;
        continue;
      }
      if (element.properties[p].is_list) {
        token = read_list(cursor, element.properties[p], is_index_list ? &polygons : nullptr);
        given_up = token == Token::bad;
        if (given_up && repairs != nullptr) token = Token::ok;
        continue;
      }
      const PlyColumns::Column& column = columns.columns[p];
      double value = nan_value;
      token = cursor.number(value);
      if (token == Token::bad && repairs != nullptr &&
          !(roles_[e] == Role::vertices && is_coordinate(column))) {
        if (column.values != nullptr) ++(*repairs)[Repair::bad_attributes];
        value = nan_value;
        cursor.word();
        token = Token::ok;
      }
      if (token != Token::ok) break;
      if (column.values != nullptr) column.values[row] = value;
      if (column.normals != nullptr) column.normals[3 * row] = static_cast<float>(value);
    }
    if (columns.numbers != nullptr) close_numbers(*columns.numbers, token == Token::ok);
    if (token == Token::ok) {
      if (columns.index_list >= 0) given_up ? polygons.give_up_polygon() : polygons.close_polygon();
      cursor.skip_line();
    } else {
      polygons.corners.resize(polygons.begin.back());
    }
    return token;
  }

  bool is_coordinate(const PlyColumns::Column& column) const {
    return column.values == mesh_.x.data() || column.values == mesh_.y.data() ||
           column.values == mesh_.z.data();
  }

  // A number that cannot be read is NaN: it costs the coordinates of the face alone.
  static Token read_numbers(TextCursor& cursor, PlyNumberList& list) {
    std::int64_t length = 0;
    if (const Token token = cursor.length(length); token != Token::ok) return token;
    for (std::int64_t k = 0; k < length; ++k) {
      double value = nan_value;
      const Token token = cursor.number(value);
      if (token == Token::ended) return token;
      if (token == Token::bad) cursor.word();
      list.values.push_back(static_cast<float>(value));
    }
    return Token::ok;
  }
  // Drops the numbers of a row that is missing.
  static void close_numbers(PlyNumberList& list, bool has_row) {
    if (has_row)
      list.begin.push_back(list.values.size());
    else
      list.values.resize(list.begin.back());
  }

  // A whole number, with a point or an exponent where the type of the header is real.
  static Token read_whole(TextCursor& cursor, PlyType type, std::int64_t& value) {
    const Token token = cursor.integer(value);
    if (token != Token::bad || !is_real(type)) return token;
    const char* const next = text::parse_whole_number(cursor.at, cursor.end, value);
    if (next == nullptr) return Token::bad;
    cursor.at = next;
    return Token::ok;
  }

  static Token read_list(TextCursor& cursor, const PlyProperty& list, PolygonPart* polygons) {
    std::int64_t length = 0, number = 0;
    if (const Token token = read_whole(cursor, list.count_type, length); token != Token::ok) return token;
    if (const Token token = cursor.fitting(length); token != Token::ok) return token;
    for (std::int64_t k = 0; k < length; ++k) {
      if (polygons == nullptr) {
        if (cursor.word().empty()) return Token::ended;
        continue;
      }
      if (const Token token = read_whole(cursor, list.type, number); token != Token::ok) return token;
      polygons->corners.push_back(text::to_index(number));
    }
    return Token::ok;
  }

  // Rows of an ascii file that can be there at most: a number and a separator take two bytes.
  static std::uint64_t rows_that_fit(const PlyElement& element, std::size_t bytes) {
    return element.properties.empty()
               ? 0
               : std::min<std::uint64_t>(element.count, (bytes + 1) / 2 / element.properties.size());
  }

  // One row per line everywhere and nothing to repair: the usual large file. False: read in order.
  bool read_lines(std::string_view body) {
    std::vector<std::uint64_t> end_row;
    std::uint64_t rows = 0;
    for (const PlyElement& element : header_.elements) {
      if (element.count > rows_that_fit(element, body.size())) return false;
      end_row.push_back(rows += element.count);
    }
    std::vector<PlyColumns> columns;
    for (std::size_t e = 0; e < roles_.size(); ++e)
      columns.push_back(make_columns(e, header_.elements[e].count));
    std::vector<PolygonPart> unused;
    const auto begin_blocks = [&](std::size_t blocks) {
      for (std::vector<PolygonPart>* const parts : {&faces_, &strips_, &unused}) parts->assign(blocks, {});
    };
    const auto read_line = [&](std::size_t block, std::uint64_t ordinal, TextCursor line) {
      const auto e = static_cast<std::size_t>(std::upper_bound(end_row.begin(), end_row.end(), ordinal) -
                                              end_row.begin());
      const std::uint64_t row = ordinal - (e == 0 ? 0 : end_row[e - 1]);
      std::vector<PolygonPart>& parts = columns[e].index_list >= 0 ? parts_of(roles_[e]) : unused;
      return read_row(line, e, row, columns[e], parts[block], nullptr) == Token::ok;
    };
    if (text::for_each_line(body, rows, false, rule_.block_bytes, cancel_, begin_blocks, read_line))
      return true;
    mesh_ = {};
    material_attributes_.clear();
    faces_.clear();
    strips_.clear();
    return false;
  }

  // Comments belong to the header, but some files have them between rows. False at the end.
  static bool skip_comments(TextCursor& cursor) {
    while (cursor.skip_to_token()) {
      TextCursor ahead = cursor;
      if (*cursor.at != 'c' || ahead.word() != "comment") return true;
      cursor.skip_line();
    }
    return false;
  }

  void read_ascii(std::string_view body) {
    TextCursor cursor{body.data(), body.data() + body.size(), false};
    for (std::size_t e = 0; e < roles_.size(); ++e) {
      const PlyElement& element = header_.elements[e];
      const std::uint64_t fit = rows_that_fit(element, static_cast<std::size_t>(cursor.end - cursor.at));
      const PlyColumns columns = make_columns(e, fit);
      std::vector<PolygonPart>& parts = parts_of(roles_[e]);
      PolygonPart unused;
      parts.resize(1);
      PolygonPart& polygons = columns.index_list >= 0 ? parts[0] : unused;
      std::uint64_t row = element.properties.empty() ? element.count : 0;
      bool cut = !complete_;  // in a row that is not there then
      // A number too few would shift all vertices that follow: where each has had a line, the next one has,
      // too.
      bool has_line = roles_[e] == Role::vertices;
      for (; row < fit; ++row) {
        if (row % rows_between_checks == 0) cancel_.check();
        if (!skip_comments(cursor)) break;
        const char* const start = cursor.at;
        const char* const line_end = has_line ? text::find_line_end(start, cursor.end) : cursor.end;
        const Token token = read_row(cursor, e, row, columns, polygons, &mesh_.repairs);
        cut = token == Token::ended;
        if (cut) break;
        if (token == Token::bad)
          text::fail_at(content_, cursor.at,
                        "vertex " + std::to_string(row) + " of " + std::to_string(element.count) + ": " +
                            text::quoted(content_, cursor.at) + " is not a number");
        if (cursor.at - line_end <= 1) continue;
        if (row > 0)
          text::fail_at(content_, start,
                        "vertex " + std::to_string(row) + " of " + std::to_string(element.count) +
                            " has fewer numbers on its line than the header promises");
        has_line = false;
      }
      // Without a line end behind it and with rows missing, the last row was probably cut in the middle of a
      // number.
      if (!cut && row < element.count && row > 0 && cursor.at == cursor.end &&
          !text::is_separator(content_.back())) {
        --row;
        if (columns.index_list >= 0) {
          polygons.begin.pop_back();
          polygons.corners.resize(polygons.begin.back());
        }
        if (columns.numbers != nullptr) {
          columns.numbers->begin.pop_back();
          columns.numbers->values.resize(columns.numbers->begin.back());
        }
      }
      end_element(e, row);
    }
    if (complete_ && skip_comments(cursor))
      rest_ = {cursor.at, static_cast<std::size_t>(cursor.end - cursor.at)};
  }

  void finish() {
    const bool strips =
        std::any_of(strips_.begin(), strips_.end(), [](const PolygonPart& p) { return p.count() > 0; });
    if (strips) faces_.push_back(triangles_of_strips(strips_));
    join_polygons(faces_, mesh_);
    if (mesh_.polygon_count() == 0 && !complete_)
      throw ItemError(Status::unreadable, "the file ends in " + cut_in_ + ", before any face");
    if (mesh_.polygon_count() == 0) throw ItemError(Status::empty, "the strips hold no triangle");
    if (mesh_.corners.empty())
      throw ItemError(Status::unreadable, "none of " + std::to_string(mesh_.polygon_count()) +
                                              " faces has a corner that can be read");
    // Faces that strips gave have no attributes.
    for (ScalarAttribute& attribute : mesh_.face_attributes)
      attribute.values.resize(mesh_.polygon_count(), nan_value);
    const bool blank = std::all_of(rest_.begin(), rest_.end(), text::is_separator);
    if (!blank) mesh_.repairs[Repair::extra_data] = saturated(rest_.size());
  }

  std::string_view content_;
  const CancelToken& cancel_;
  const BlockRule& rule_;
  const MeshSurroundings& around_;
  PlyHeader header_;
  bool textured_;           // images are asked for and named
  bool wants_coordinates_;  // texture coordinates, for images or for themselves
  PlyNumberList wedges_;    // those of faces
  std::vector<Role> roles_;
  PolygonMesh mesh_;
  std::vector<ScalarAttribute> material_attributes_;
  std::vector<PolygonPart> faces_, strips_;
  bool complete_ = true;  // no row was missing so far
  std::string cut_in_;
  std::string_view rest_;  // the bytes after the last element
};

}  // namespace

PolygonMesh read_ply(std::string_view content, const CancelToken& cancel, const BlockRule& rule,
                     const MeshSurroundings& around) {
  return PlyMeshReader(content, cancel, rule, around).read();
}

}  // namespace meander
