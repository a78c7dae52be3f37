/* The C interface of libmeander.so: what the package in jobs/python/meander calls, and what other languages
 * may.
 *
 * Objects are made by the functions that return them and released by meander_release. A function that fails
 * returns NULL or a negative number, and meander_error says why. Texts that are returned are UTF-8 and hold
 * until the next call from the same thread. Every function may be called from any thread, but no two at a
 * time with the same work, apart from meander_offer and meander_row. */
#ifndef MEANDER_INTERFACE_H
#define MEANDER_INTERFACE_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct meander_object meander_object;

/* The version, and the lists of names, columns, settings and options: see about_text.h. */
const char* meander_about(void);

/* Why the last call from this thread failed: {"kind": ..., "text": ...}. Kinds: "sampling", a mesh that
 * cannot be sampled (with its "status"); "value", an argument that makes no sense; "option", one whose name
 * is the text and whose value is of another type or range; "function", the function of a surface gave up;
 * "system"; "memory"; "internal". */
const char* meander_error(void);

/* Work that still runs is canceled and waited for. NULL is let pass. */
void meander_release(meander_object* object);

/* What samples meshes. options: a JSON object of the options of `meander.sample` (see sample_options.h).
 * of_files: meshes are read from files, whose colors, texture coordinates and attributes samples may take
 * over. path: the file, or NULL for many: attributes that it declares as integers are columns of classes. */
meander_object* meander_sampler(const char* options, int of_files, const char* path);

/* A mesh file of any format, or ARCHIVE/MEMBER, with what the samples of `sampler` take over; NULL: nothing.
 */
meander_object* meander_mesh_of_file(const char* path, meander_object* sampler);

/* Numbers of the vertices or the faces under a name. */
typedef struct {
  const char* name;
  const double* values; /* count x width; NaN: none */
  uint64_t width;       /* 1 to 4 */
  int32_t of_faces, classes;
} meander_attribute;

typedef struct {
  const double* vertices; /* 3 vertex_count, rows of x, y, z */
  uint64_t vertex_count;
  const void* faces; /* face_count x width numbers of vertices */
  uint64_t face_count, width;
  int32_t corner_bytes, corners_are_signed; /* their type: 4 or 8; 0 or 1 */
  const double* normals;                    /* 3 vertex_count, or NULL */
  const double* density;                    /* of the faces or the vertices, or NULL */
  const uint8_t* content;                   /* 32 bytes; NULL: a digest of vertices and faces */
  int32_t density_of_faces;
  int32_t check;       /* refuse numbers of vertices that are not there, and vertices that are not finite */
  const float* colors; /* 3 numbers in [0, 1] as displayed for each face or vertex, NaN: none; or NULL */
  int32_t colors_of_faces;
  const meander_attribute* attributes;
  uint64_t attribute_count;
} meander_arrays;

/* Copies the arrays. */
meander_object* meander_mesh_of_arrays(const meander_arrays* arrays);

/* A copy of a mesh with a density: count numbers, of its faces or its vertices. */
meander_object* meander_mesh_with_density(meander_object* mesh, const double* density, uint64_t count,
                                          int of_faces);

/* What a mesh or a row holds, by the names of the members of meander.Mesh and meander.Samples. "arrays" and
 * "descriptors" say where each is, [address, type, n, columns] with a type as numpy writes it ("<f4"),
 * without columns for n values, and null for none; they belong to the object and may be written to. Real
 * numbers are texts in hexadecimal ("0x1.8p+2"). "attributes" are places like "arrays", "names" the names of
 * classes as JSON in a text. Of a row that could not be sampled: {"status": ..., "reason": ...}. */
const char* meander_text(meander_object* object);

/* One piece of work, which the functions below start, once. */
meander_object* meander_work(void);

/* Samples a mesh: short work at once (1), long work in a thread of its own (0). threads: 0 (all of the
 * machine) to 1024; timeout: seconds, 0 for none. Unless keep_mesh, the mesh must not be used again. */
int meander_sample(meander_object* work, meander_object* sampler, meander_object* mesh, int threads,
                   double timeout, int keep_mesh);

/* A surface by its name or file. */
int meander_sample_surface(meander_object* work, const char* name, const char* options, double tolerance,
                           int threads, double timeout);

/* Positions (3 count) at count parameters; not 0: gives up. */
typedef int (*meander_function)(void* context, uint64_t count, const double* u, const double* v,
                                double* positions);

/* A surface that a function describes, which is called from this thread before this returns. content: as
 * above. */
int meander_sample_function(meander_object* work, meander_function function, void* context,
                            const uint8_t* content, const char* options, double tolerance, double timeout);

/* Starts to sample the meshes that meander_offer gives, until meander_close. */
int meander_sample_many(meander_object* work, meander_object* sampler, int threads, double timeout);

/* 1: the mesh was taken and must not be used again; 0: there was no room within so many milliseconds. */
int meander_offer(meander_object* work, uint64_t index, meander_object* mesh, int milliseconds);
int meander_close(meander_object* work);

/* 1: the work has ended; 0: not within so many milliseconds. Negative where it failed. */
int meander_wait(meander_object* work, int milliseconds);

/* 1: one of the rows that are done, each given once, and the index of its mesh; 0: there is none within so
 * many milliseconds. */
int meander_row(meander_object* work, meander_object** row, uint64_t* index, int milliseconds);

typedef struct {
  const char* name;
  const void* values; /* rows x columns */
  char type;          /* 'd' double, 'f' float, 'I' uint32, 'B' uint8 */
  uint64_t rows, columns;
} meander_array;

/* Calls a function over arrays, of array_functions.cpp or of the laboratory (jobs/laboratory/functions).
 * options: a JSON object. subject: a mesh, what an earlier call returned, whose model the function works on,
 * or NULL. meander_text of the object that is returned has its numbers and arrays. */
meander_object* meander_call(const char* function, const char* options, const meander_array* arrays,
                             uint64_t count, meander_object* subject);

#ifdef __cplusplus
}
#endif

#endif
