#include "jobs/python/interface.h"

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "io/archive/model_bytes.h"
#include "io/digest.h"
#include "io/json_writer.h"
#include "io/run_error.h"
#include "jobs/cli/usage_error.h"
#include "jobs/inputs/surface_sources.h"
#include "jobs/python/about_text.h"
#include "jobs/python/array_functions.h"
#include "jobs/python/array_mesh.h"
#include "jobs/python/laboratory_call.h"
#include "jobs/python/row_text.h"
#include "jobs/python/sample_options.h"
#include "jobs/python/sampling_work.h"
#include "jobs/rows/attribute_types.h"
#include "kernels/sample/column_makers.h"

struct meander_object {
  meander_object() = default;
  meander_object(const meander_object&) = delete;
  meander_object& operator=(const meander_object&) = delete;
  virtual ~meander_object() = default;
};

namespace {

using namespace meander;

// Ends the work when the function of a surface gives up.
struct FunctionGaveUp : std::runtime_error {
  FunctionGaveUp() : std::runtime_error("the function of a surface gave up") {}
};

struct SamplerObject : meander_object {
  explicit SamplerObject(const SampleParameters& parameters)
      : sampler(std::make_shared<ModelSampler>(parameters)) {}
  SharedSampler sampler;
};
struct MeshObject : meander_object {
  explicit MeshObject(ContentMesh given) : mesh(std::make_shared<ContentMesh>(std::move(given))) {}
  SharedMesh mesh;
};
struct WorkObject : meander_object {
  SamplingWork work;
};
struct RowObject : meander_object {
  explicit RowObject(SampledRow given) : row(std::move(given)) {}
  WeightedRow row;
};
struct LaboratoryObject : meander_object {
  explicit LaboratoryObject(LaboratoryResult given) : result(std::move(given)) {}
  LaboratoryResult result;
};

template <class Object>
Object& as(meander_object* object) {
  auto* const is = dynamic_cast<Object*>(object);
  if (is == nullptr) throw std::invalid_argument("an object of another kind is needed here");
  return *is;
}

thread_local std::string last_error, last_text;

const char* keep(std::string text) {
  last_text = std::move(text);
  return last_text.c_str();
}

// Notes the exception in flight, for meander_error.
void note_error() noexcept {
  const auto note = [](const char* kind, const char* text, std::string_view status = {}) {
    JsonWriter json;
    json.begin_object();
    json.member("kind", kind);
    json.member("text", text);
    if (!status.empty()) json.member("status", status);
    json.end_object();
    last_error = json.text();
  };
  try {
    try {
      throw;
    } catch (const ItemError& error) {
      note("sampling", error.what(), name_of(error.status()));
    } catch (const OptionRefused& error) {
      note("option", error.what());
    } catch (const FunctionGaveUp& error) {
      note("function", error.what());
    } catch (const UsageError& error) {
      note("value", error.what());
    } catch (const std::invalid_argument& error) {
      note("value", error.what());
    } catch (const RunError& error) {
      note("system", error.what());
    } catch (const std::bad_alloc& error) {
      note("memory", error.what());
    } catch (const std::exception& error) {
      note("internal", error.what());
    }
  } catch (...) {
    last_error.clear();  // no memory for it, or no exception of ours
  }
}

// What call() returns; `failed` where it throws.
template <class Result, class Call>
Result guarded(Result failed, const Call& call) noexcept {
  try {
    return call();
  } catch (...) {
    note_error();
    return failed;
  }
}
template <class Call>
meander_object* made(const Call& call) noexcept {
  return guarded<meander_object*>(nullptr, [&]() -> meander_object* { return call().release(); });
}
template <class Call>
int done(const Call& call) noexcept {
  return guarded(-1, [&] {
    call();
    return 0;
  });
}

ModelPlace place_of(const std::string& path) {
  ModelPlace place{path, find_packed(path)};
  if (!mesh_format_of(place.packed ? place.packed.facts().name : path, place.format))
    throw ItemError(Status::unsupported_format, "`" + path + "` is no " + mesh_extensions("or") + " file");
  return place;
}

ContentMesh mesh_of_file(const std::string& path, const SampleParameters& parameters) {
  const ModelBytes bytes(place_of(path), ~std::uint64_t{0},
                         any_reads(parameters.columns, &ColumnReads::colors));
  ContentMesh mesh;
  mesh.content = bytes.content_sha256();
  mesh.mesh = bytes.mesh({}, {}, {reads_coordinates(parameters), parameters.attributes});
  return mesh;
}

// Columns of attributes hold classes as in a run over this file.
void choose_attribute_kinds(const char* path, std::vector<AttributeColumn>& columns) {
  std::vector<PlanItem> items;
  if (path != nullptr) static_cast<ModelPlace&>(items.emplace_back()) = place_of(path);
  choose_kinds(columns, nullptr, items);
}

WorkLimits limits_of(int threads, double timeout) {
  if (threads < 0 || threads > 1024) throw std::invalid_argument("threads: 0 (all of the machine) to 1024");
  if (!(timeout >= 0 && timeout <= 1e9)) throw std::invalid_argument("timeout: seconds to 1e9, 0 for none");
  WorkLimits limits;
  limits.threads = threads;
  if (timeout > 0) limits.timeout = timeout;
  return limits;
}

SurfaceFunction surface_function(meander_function function, void* context) {
  return [=](std::span<const double> u, std::span<const double> v, std::span<double> positions) {
    if (function(context, u.size(), u.data(), v.data(), positions.data()) != 0) throw FunctionGaveUp();
    require_finite(positions, "the surface's positions");
  };
}

}  // namespace

const char* meander_about() {
  return guarded<const char*>(nullptr, [] { return keep(about_text()); });
}

const char* meander_error() { return last_error.c_str(); }

void meander_release(meander_object* object) { delete object; }

meander_object* meander_sampler(const char* options, int of_files, const char* path) {
  return made([&] {
    SampleParameters parameters = sample_parameters(options, of_files != 0);
    if (of_files != 0 && !parameters.attributes.empty()) choose_attribute_kinds(path, parameters.attributes);
    return std::make_unique<SamplerObject>(parameters);
  });
}

meander_object* meander_mesh_of_file(const char* path, meander_object* sampler) {
  return made([&] {
    return std::make_unique<MeshObject>(mesh_of_file(
        path, sampler != nullptr ? as<SamplerObject>(sampler).sampler->parameters() : SampleParameters{}));
  });
}

meander_object* meander_mesh_with_density(meander_object* mesh, const double* density, std::uint64_t count,
                                          int of_faces) {
  return made([&] {
    ContentMesh copy = *as<MeshObject>(mesh).mesh;
    set_density(copy.mesh, {density, count}, of_faces != 0);
    return std::make_unique<MeshObject>(std::move(copy));
  });
}

meander_object* meander_mesh_of_arrays(const meander_arrays* arrays) {
  return made([&] { return std::make_unique<MeshObject>(mesh_of_arrays(*arrays)); });
}

const char* meander_text(meander_object* object) {
  return guarded<const char*>(nullptr, [&] {
    if (auto* const row = dynamic_cast<RowObject*>(object)) return keep(text_of(row->row));
    if (auto* const called = dynamic_cast<LaboratoryObject*>(object)) return keep(text_of(called->result));
    return keep(text_of(*as<MeshObject>(object).mesh));
  });
}

meander_object* meander_work() {
  return made([] { return std::make_unique<WorkObject>(); });
}

int meander_sample(meander_object* work, meander_object* sampler, meander_object* mesh, int threads,
                   double timeout, int keep_mesh) {
  return guarded(-1, [&]() -> int {
    SamplingWork& sampling = as<WorkObject>(work).work;
    sampling.sample(as<SamplerObject>(sampler).sampler, as<MeshObject>(mesh).mesh,
                    limits_of(threads, timeout), keep_mesh != 0);
    return sampling.ended_within(std::chrono::milliseconds(0));
  });
}

int meander_sample_surface(meander_object* work, const char* name, const char* options, double tolerance,
                           int threads, double timeout) {
  return done([&] {
    as<WorkObject>(work).work.sample_surface(name, surface_parameters(options, tolerance),
                                             limits_of(threads, timeout));
  });
}

int meander_sample_function(meander_object* work, meander_function function, void* context,
                            const std::uint8_t* content, const char* options, double tolerance,
                            double timeout) {
  return done([&] {
    const SurfaceSampleParameters parameters = surface_parameters(options, tolerance);
    const SurfaceFunction positions = surface_function(function, context);
    Content named{};
    if (content != nullptr) {
      std::copy_n(content, named.size(), named.begin());
    } else {
      const std::vector<double> grid = surface_grid(positions);
      named = sha256(std::as_bytes(std::span(grid)));
    }
    as<WorkObject>(work).work.sample_function(FunctionSurface(positions, named), named, parameters,
                                              limits_of(1, timeout));
  });
}

int meander_sample_many(meander_object* work, meander_object* sampler, int threads, double timeout) {
  return done([&] {
    as<WorkObject>(work).work.sample_many(as<SamplerObject>(sampler).sampler, limits_of(threads, timeout));
  });
}

int meander_offer(meander_object* work, std::uint64_t index, meander_object* mesh, int milliseconds) {
  return guarded(-1, [&]() -> int {
    return as<WorkObject>(work).work.offer(index, as<MeshObject>(mesh).mesh,
                                           std::chrono::milliseconds(milliseconds));
  });
}

int meander_close(meander_object* work) {
  return done([&] { as<WorkObject>(work).work.close(); });
}

int meander_wait(meander_object* work, int milliseconds) {
  return guarded(-1, [&]() -> int {
    return as<WorkObject>(work).work.ended_within(std::chrono::milliseconds(milliseconds));
  });
}

int meander_row(meander_object* work, meander_object** row, std::uint64_t* index, int milliseconds) {
  return guarded(-1, [&] {
    auto taken = as<WorkObject>(work).work.take_row(std::chrono::milliseconds(milliseconds));
    if (!taken) return 0;
    *index = taken->index;
    *row = std::make_unique<RowObject>(std::move(*taken)).release();
    return 1;
  });
}

namespace {

GivenArray given_array(const meander_array& array) {
  const std::uint64_t values = array.rows * array.columns;
  const auto span = [&](auto value) {
    return std::span(static_cast<const decltype(value)*>(array.values), values);
  };
  GivenArray given{array.name, {}, array.rows, array.columns};
  if (array.type == 'd')
    given.values = span(double{});
  else if (array.type == 'f')
    given.values = span(float{});
  else if (array.type == 'I')
    given.values = span(std::uint32_t{});
  else if (array.type == 'B')
    given.values = span(std::uint8_t{});
  else
    throw std::invalid_argument(given.name +
                                " is an array of another type than double, float, uint32 or uint8");
  return given;
}

}  // namespace

meander_object* meander_call(const char* function, const char* options, const meander_array* arrays,
                             std::uint64_t count, meander_object* subject) {
  return made([&] {
    std::vector<GivenArray> given;
    for (std::uint64_t i = 0; i < count; ++i) given.push_back(given_array(arrays[i]));
    LaboratorySubject about;
    if (const auto* const mesh = dynamic_cast<MeshObject*>(subject))
      about.mesh = {mesh->mesh, &mesh->mesh->mesh};
    else if (subject != nullptr)
      about.staged = as<LaboratoryObject>(subject).result.staged;
    const LaboratoryArguments arguments(options, std::move(given), std::move(about));
    std::optional<LaboratoryResult> result = call_array_function(function, arguments);
    return std::make_unique<LaboratoryObject>(result ? std::move(*result)
                                                     : call_laboratory(function, arguments));
  });
}
