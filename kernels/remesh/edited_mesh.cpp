#include "kernels/remesh/edited_mesh.h"

namespace meander {

Vector3 EditedMesh::area_vector(std::uint32_t triangle) const {
  const std::size_t h = 3 * std::size_t{triangle};
  const Vector3 a = position[vertex[h]];
  return cross(position[vertex[h + 1]] - a, position[vertex[h + 2]] - a);
}

bool EditedMesh::are_neighbors(std::uint32_t v, std::uint32_t w) const {
  std::uint32_t of_v = out[v], of_w = out[w];
  for (;;) {
    if (end(of_v) == w || apex(of_v) == w) return true;
    of_v = opposite[previous_half_edge(of_v)];
    of_w = opposite[previous_half_edge(of_w)];
    if (of_v == no_index || of_v == out[v] || of_w == no_index || of_w == out[w]) break;
  }
  if (of_v == no_index || of_v == out[v]) return false;  // walked all around v
  std::uint32_t h = out[w];
  do {
    if (end(h) == v || apex(h) == v) return true;
    h = opposite[previous_half_edge(h)];
  } while (h != no_index && h != out[w]);
  return false;
}

std::uint32_t EditedMesh::add_vertex(Vector3 at) {
  position.push_back(at);
  out.push_back(no_index);
  return static_cast<std::uint32_t>(position.size() - 1);
}

std::uint32_t EditedMesh::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto h = static_cast<std::uint32_t>(vertex.size());
  vertex.insert(vertex.end(), {a, b, c});
  opposite.insert(opposite.end(), 3, no_index);
  crease.insert(crease.end(), 3, std::uint8_t{0});
  return h;
}

void EditedMesh::glue(std::uint32_t g, std::uint32_t h) {
  if (g != no_index) opposite[g] = h;
  if (h != no_index) opposite[h] = g;
}

void EditedMesh::split_triangle(std::uint32_t t, std::uint32_t p) {
  const std::uint32_t h0 = 3 * t, h1 = h0 + 1, h2 = h0 + 2;
  const std::uint32_t a = vertex[h0], b = vertex[h1], c = vertex[h2];
  const std::uint32_t k = add_triangle(b, c, p), l = add_triangle(c, a, p);
  glue(k, opposite[h1]);
  glue(l, opposite[h2]);
  crease[k] = crease[h1];
  crease[l] = crease[h2];
  crease[h1] = crease[h2] = 0;
  vertex[h2] = p;
  glue(h1, k + 2);
  glue(k + 1, l + 2);
  glue(l + 1, h2);
  if (out[b] == h1) out[b] = k;
  if (out[c] == h2) out[c] = l;
  out[p] = h2;
}

void EditedMesh::split_edge(std::uint32_t h, std::uint32_t p) {
  const std::uint32_t g = opposite[h];
  const std::uint32_t h1 = next_half_edge(h), b = vertex[h1];
  // The half of the triangle of h behind p.
  const std::uint32_t k = add_triangle(p, b, apex(h));
  glue(k + 1, opposite[h1]);
  crease[k] = crease[h];
  crease[k + 1] = crease[h1];
  crease[h1] = 0;
  vertex[h1] = p;
  glue(h1, k + 2);
  if (out[b] == h1) out[b] = k + 1;
  out[p] = k;
  if (g == no_index) return;
  // And that of the triangle on the other side.
  const std::uint32_t g1 = next_half_edge(g), a = vertex[g1];
  const std::uint32_t l = add_triangle(p, a, apex(g));
  glue(l + 1, opposite[g1]);
  crease[l] = crease[g];
  crease[l + 1] = crease[g1];
  crease[g1] = 0;
  vertex[g1] = p;
  glue(g1, l + 2);
  if (out[a] == g1) out[a] = l + 1;
  glue(h, l);
  glue(k, g);
}

void EditedMesh::flip(std::uint32_t h) {
  const std::uint32_t h1 = next_half_edge(h), h2 = previous_half_edge(h), g = opposite[h];
  const std::uint32_t g1 = next_half_edge(g), g2 = previous_half_edge(g);
  const std::uint32_t a = vertex[h], b = vertex[g], c = vertex[h2], d = vertex[g2];
  const std::uint32_t beyond_ca = opposite[h2], beyond_db = opposite[g2];
  const std::uint8_t crease_ca = crease[h2], crease_db = crease[g2];
  vertex[h] = d;  // d b c, whose h1 stays
  vertex[h2] = c;
  vertex[g] = c;  // c a d, whose g1 stays
  vertex[g2] = d;
  glue(h, beyond_db);
  glue(g, beyond_ca);
  glue(h2, g2);
  crease[h] = crease_db;
  crease[g] = crease_ca;
  crease[h2] = crease[g2] = 0;
  if (out[a] == h) out[a] = g1;
  if (out[b] == g) out[b] = h1;
  if (out[c] == h2) out[c] = g;
  if (out[d] == g2) out[d] = h;
}

void EditedMesh::remove_at_boundary(std::uint32_t h) {
  const std::uint32_t beyond_n = opposite[next_half_edge(h)], beyond_p = opposite[previous_half_edge(h)];
  const std::uint32_t a = start(h), c = apex(h);
  opposite[beyond_n] = opposite[beyond_p] = no_index;
  out[a] = beyond_p;
  out[c] = beyond_n;
  for (std::uint32_t k = 0; k < 3; ++k) vertex[3 * std::size_t{h / 3} + k] = no_index;
}

std::uint32_t EditedMesh::close_triangle(std::uint32_t h) {
  const std::uint32_t n = next_half_edge(h), p = previous_half_edge(h);
  const std::uint32_t beyond_n = opposite[n], beyond_p = opposite[p], c = vertex[p];
  const std::uint8_t is_crease = crease[n] | crease[p];
  glue(beyond_n, beyond_p);
  for (const std::uint32_t side : {beyond_n, beyond_p})
    if (side != no_index) crease[side] = is_crease;
  // Were the edge of n a boundary, p would not be the first half-edge of c.
  if (out[c] == p) out[c] = beyond_n;
  const std::uint32_t t = h / 3;
  for (std::uint32_t k = 0; k < 3; ++k) vertex[3 * t + k] = no_index;
  return beyond_p != no_index ? beyond_p : next_half_edge(beyond_n);
}

void EditedMesh::begin_at_boundary(std::uint32_t v, std::uint32_t h) {
  std::uint32_t at = h;
  while (opposite[at] != no_index) {
    at = next_half_edge(opposite[at]);
    if (at == h) break;
  }
  out[v] = at;
}

void EditedMesh::collapse(std::uint32_t h, std::uint32_t v) {
  const std::uint32_t w = start(h) == v ? end(h) : start(h), g = opposite[h];
  const bool keeps_begin = is_boundary_vertex(w) && !is_boundary_vertex(v);
  const bool has_boundary = is_boundary_vertex(w) || is_boundary_vertex(v);
  const std::uint32_t first = out[v];
  std::uint32_t at = first;
  do {  // for_outgoing, whose walk does not read the vertices that change
    vertex[at] = w;
    at = opposite[previous_half_edge(at)];
  } while (at != first && at != no_index);
  std::uint32_t of_w = close_triangle(h);
  if (g != no_index) of_w = close_triangle(g);
  out[v] = no_index;
  // Without a walk around w, which may have very many neighbors, where nothing there has changed.
  if (!has_boundary)
    out[w] = of_w;
  else if (!keeps_begin || vertex[out[w]] != w)
    begin_at_boundary(w, of_w);
}

EditedMesh edited_component(const PreparedMesh& mesh, const Component& component) {
  EditedMesh edited;
  const std::uint32_t vertices = component.vertex_end - component.vertex_begin;
  const std::size_t begin = 3 * std::size_t{component.triangle_begin};
  const std::size_t end = 3 * std::size_t{component.triangle_end};
  edited.position.reserve(vertices);
  for (std::uint32_t v = component.vertex_begin; v < component.vertex_end; ++v)
    edited.position.push_back(mesh.position(v));
  edited.out.assign(vertices, no_index);
  edited.vertex.resize(end - begin);
  edited.opposite.resize(end - begin);
  edited.crease.assign(end - begin, 0);
  for (std::size_t h = begin; h < end; ++h) {
    const std::uint32_t v = mesh.triangles[h] - component.vertex_begin, other = mesh.opposite[h];
    edited.vertex[h - begin] = v;
    edited.opposite[h - begin] = other == no_index ? no_index : other - static_cast<std::uint32_t>(begin);
    if (edited.out[v] == no_index || other == no_index) edited.out[v] = static_cast<std::uint32_t>(h - begin);
  }
  return edited;
}

}  // namespace meander
