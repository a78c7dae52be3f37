// The module meander._core: what the package in jobs/python/meander is made of. Nothing here runs Python on a
// thread of TBB: work goes on without the GIL, and what it made becomes Python objects in the caller's
// thread.
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/archive/model_bytes.h"
#include "io/run_error.h"
#include "jobs/inputs.h"
#include "jobs/python/array_mesh.h"
#include "jobs/python/callable_surface.h"
#include "jobs/python/interruptible.h"
#include "jobs/python/measures.h"
#include "jobs/python/row_arrays.h"
#include "jobs/python/sample_options.h"
#include "jobs/surface_sources.h"
#include "kernels/core/failure.h"
#include "kernels/model/sampler.h"
#include "kernels/surface/sample_surface.h"
#include "kernels/surface/surface_row.h"
#include "meander_version.h"

namespace py = pybind11;

namespace meander {

namespace {

// ---- options

SampleOptions options_of(const py::kwargs& given) {
  SampleOptions options;
  for (const auto& [key, value] : given) {
    const auto name = py::cast<std::string>(key);
    const auto set = [&](auto& member) {
      try {
        member = py::cast<std::decay_t<decltype(member)>>(value);
      } catch (const py::cast_error&) {
        if (PyLong_Check(value.ptr()) != 0 || PyFloat_Check(value.ptr()) != 0)
          throw py::value_error(fmt::format("{} cannot be {}", name, std::string(py::str(value))));
        throw py::type_error(fmt::format("{} cannot be {}", name, std::string(py::repr(py::handle(value)))));
      }
    };
    if (name == "n")
      set(options.samples);
    else if (name == "seed")
      set(options.seed);
    else if (name == "method")
      set(options.method);
    else if (name == "sequence")
      set(options.sequence);
    else if (name == "order")
      set(options.order);
    else if (name == "normalize")
      set(options.normalize);
    else if (name == "spacing")
      set(options.spacing);
    else if (name == "density")
      set(options.density);
    else if (name == "density_floor")
      set(options.density_floor);
    else if (name == "density_exponent")
      set(options.density_exponent);
    else if (name == "curve")
      set(options.curve);
    else if (name == "curved")
      set(options.curved);
    else if (name == "topology")
      set(options.topology);
    else if (name == "describe")
      set(options.describe);
    else if (name == "bins")
      set(options.bins);
    else
      throw py::type_error("no option `" + name + "`");
  }
  return options;
}

// ---- meshes

using SharedMesh = std::shared_ptr<ContentMesh>;

SharedMesh read_mesh_file(const std::string& path) {
  const py::gil_scoped_release released;
  const PackedFile packed = find_packed(path);
  MeshFormat format{};
  if (!mesh_format_of(packed ? packed.facts().name : path, format))
    throw ItemError(Status::unsupported_format,
                    "`" + path + "` is no " + mesh_extensions("or") + " file");
  const ModelBytes bytes({path, packed, format});
  auto mesh = std::make_shared<ContentMesh>();
  mesh->content = bytes.content_sha256();
  mesh->mesh = bytes.mesh();
  return mesh;
}

py::array_t<double> vertices_of(const ContentMesh& mesh) {
  const PolygonMesh& m = mesh.mesh;
  py::array_t<double> vertices({static_cast<py::ssize_t>(m.vertex_count()), py::ssize_t{3}});
  double* out = vertices.mutable_data();
  for (std::size_t v = 0; v < m.vertex_count(); ++v, out += 3) {
    out[0] = m.x[v];
    out[1] = m.y[v];
    out[2] = m.z[v];
  }
  return vertices;
}

// All faces with equally many corners as an array; else None.
py::object faces_of(const ContentMesh& mesh) {
  const PolygonMesh& m = mesh.mesh;
  const std::size_t faces = m.polygon_count();
  const std::size_t width = faces > 0 ? m.polygon_begin[1] - m.polygon_begin[0] : 3;
  for (std::size_t f = 0; f < faces; ++f)
    if (m.polygon_begin[f + 1] - m.polygon_begin[f] != width) return py::none();
  return py::array_t<std::uint32_t>({static_cast<py::ssize_t>(faces), static_cast<py::ssize_t>(width)},
                                    m.corners.data());
}

// ---- sampling

// Above this a call is worth a thread of its own, so that Ctrl-C can end it.
constexpr std::size_t long_work = 200000;

CancelToken token_of(const std::atomic<bool>* cancelled, std::optional<double> timeout) {
  CancelToken token;
  token.cancelled = cancelled;
  if (timeout)
    token.deadline =
        std::chrono::steady_clock::now() + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                               std::chrono::duration<double>(*timeout));
  return token;
}

void check_limits(int threads, std::optional<double> timeout) {
  if (threads < 0 || threads > 1024)
    throw py::value_error(fmt::format("threads is {}: 0 (all of the machine) to 1024", threads));
  if (timeout && !(*timeout > 0 && *timeout <= 1e9))
    throw py::value_error(fmt::format("timeout is {}: seconds above 0, to 1e9", *timeout));
}

// Calls work() in as many threads; all that there are for 0.
template <class Work>
void with_threads(int threads, const Work& work) {
  if (threads == 0) {
    work();
    return;
  }
  std::optional<oneapi::tbb::global_control> more;
  if (threads > oneapi::tbb::info::default_concurrency())
    more.emplace(oneapi::tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  oneapi::tbb::task_arena(threads).execute(work);
}

// Runs work(cancelled) in the calling thread, or where it is long in another one that Ctrl-C ends.
template <class Work>
void run_released(bool is_long, int threads, const Work& work) {
  if (!is_long) {
    const py::gil_scoped_release released;
    with_threads(threads, [&] { work(nullptr); });
    return;
  }
  BackgroundWork background([threads, &work](const std::atomic<bool>& cancelled) {
    with_threads(threads, [&] { work(&cancelled); });
  });
  background.wait();
}

bool is_long_work(const Sampler& sampler, const PolygonMesh& mesh) {
  const SampleParameters& p = sampler.parameters();
  const std::size_t spaced = p.place.sequence == SequenceKind::spaced ? 10 : 1;
  return method_of(p).makes_charts || mesh.corners.size() + spaced * p.place.samples > long_work;
}

py::dict sample_mesh(const Sampler& sampler, const ContentMesh& mesh, int threads,
                     std::optional<double> timeout) {
  check_limits(threads, timeout);
  Row row;
  run_released(is_long_work(sampler, mesh.mesh), threads, [&](const std::atomic<bool>* cancelled) {
    row = sampler.sample(mesh.mesh, mesh.content, token_of(cancelled, timeout));
  });
  return arrays_of(std::move(row), mesh.content);
}

py::dict sample_arrays(const Sampler& sampler, const MeshArrays& arrays, int threads,
                       std::optional<double> timeout) {
  check_limits(threads, timeout);
  ContentMesh mesh = mesh_of_arrays(arrays);
  Row row;
  run_released(is_long_work(sampler, mesh.mesh), threads, [&](const std::atomic<bool>* cancelled) {
    row = sampler.sample(std::move(mesh.mesh), mesh.content, token_of(cancelled, timeout));
  });
  return arrays_of(std::move(row), mesh.content);
}

// ---- many meshes

// From the thread that has the GIL to the threads that sample, and back.
class SampleQueue {
 public:
  struct Entry {
    std::size_t index = 0;
    SharedMesh mesh;
    Row row;
  };

  explicit SampleQueue(std::size_t most_waiting) : most_waiting_(most_waiting) {}

  // False when there is no room yet.
  bool offer(const Entry& entry, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, patience, [this] { return waiting_.size() < most_waiting_ || closed_; }))
      return false;
    waiting_.push_back(entry);
    changed_.notify_all();
    return true;
  }
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }
  // Blocks; none once the queue is closed and empty.
  std::optional<Entry> take() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
    if (waiting_.empty()) return std::nullopt;
    Entry entry = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    return entry;
  }
  void put(Entry entry) {
    const std::lock_guard lock(mutex_);
    done_.push_back(std::move(entry));
  }
  std::vector<Entry> take_done() {
    const std::lock_guard lock(mutex_);
    return std::exchange(done_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Entry> waiting_;
  std::vector<Entry> done_;
  std::size_t most_waiting_;
  bool closed_ = false;
};

// Closes the queue before the work that reads from it is waited for or cancelled.
struct CloseAtEnd {
  SampleQueue& queue;
  ~CloseAtEnd() { queue.close(); }
};

void sample_all(const Sampler& sampler, SampleQueue& queue, std::size_t tokens, std::optional<double> timeout,
                const std::atomic<bool>& cancelled) {
  using oneapi::tbb::filter_mode;
  using Held = std::shared_ptr<SampleQueue::Entry>;
  oneapi::tbb::parallel_pipeline(
      tokens,
      oneapi::tbb::make_filter<void, Held>(filter_mode::serial_in_order,
                                           [&](oneapi::tbb::flow_control& control) -> Held {
                                             auto entry = queue.take();
                                             if (!entry || cancelled) {
                                               control.stop();
                                               return nullptr;
                                             }
                                             return std::make_shared<SampleQueue::Entry>(std::move(*entry));
                                           }) &
          oneapi::tbb::make_filter<Held, void>(filter_mode::parallel, [&](const Held& entry) {
            entry->row =
                sampler.sample(entry->mesh->mesh, entry->mesh->content, token_of(&cancelled, timeout));
            entry->mesh->mesh = {};
            queue.put(std::move(*entry));
          }));
}

// meshes: an iterator of Mesh objects that nobody else uses, or of exceptions. Results in their order:
// members of Samples, the SamplingError of a mesh, or the exception.
py::list sample_many(const Sampler& sampler, const py::iterator& meshes, int threads,
                     std::optional<double> timeout) {
  check_limits(threads, timeout);
  const auto slots =
      static_cast<std::size_t>(threads > 0 ? threads : oneapi::tbb::info::default_concurrency());
  SampleQueue queue(2 * slots);
  py::list results;
  const auto collect = [&] {
    for (SampleQueue::Entry& entry : queue.take_done()) {
      if (entry.row.report.status == Status::ok)
        results[entry.index] = arrays_of(std::move(entry.row), entry.mesh->content);
      else
        results[entry.index] = sampling_error(entry.row.report);
    }
  };
  BackgroundWork background([&](const std::atomic<bool>& cancelled) {
    with_threads(threads, [&] { sample_all(sampler, queue, slots + 1, timeout, cancelled); });
  });
  {
    const CloseAtEnd close{queue};
    for (const py::handle item : meshes) {
      SampleQueue::Entry entry{results.size(), {}, {}};
      results.append(py::none());
      if (!py::isinstance<ContentMesh>(item)) {  // why there is none
        results[entry.index] = item;
        continue;
      }
      entry.mesh = py::cast<SharedMesh>(item);
      bool taken = false;
      while (!taken) {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        const py::gil_scoped_release released;
        taken = queue.offer(entry, std::chrono::milliseconds(50));
      }
      collect();
    }
  }
  background.wait();
  collect();
  return results;
}

// ---- surfaces

// Throws what a caller must see: an interruption, an exception of Python.
template <class Work>
Row row_or_failure(const Work& work) {
  Row row;
  try {
    row = work();
  } catch (const RunCancelled&) {
    throw;
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const py::error_already_set&) {
    throw;
  } catch (...) {
    Failure failure = current_failure("sample_surface");
    row.report.status = failure.status;
    row.report.reason = std::move(failure.reason);
  }
  return row;
}

py::dict sample_named_surface(const std::string& name, double tolerance, int threads,
                              std::optional<double> timeout, const py::kwargs& options) {
  check_limits(threads, timeout);
  const SurfaceSampleParameters parameters = surface_parameters(options_of(options), tolerance);
  check_surface_name(name);
  Row row;
  std::array<std::uint8_t, 32> content{};
  run_released(true, threads, [&](const std::atomic<bool>* cancelled) {
    row = row_or_failure([&] {
      const SurfaceSource source = open_surface(name);
      content = source.content_sha256;
      return surface_row(*source.surface,
                         sample_surface(*source.surface, parameters, token_of(cancelled, timeout)));
    });
  });
  return arrays_of(std::move(row), content);
}

py::dict sample_callable_surface(py::function function, double tolerance, std::optional<double> timeout,
                                 const py::object& content, const py::kwargs& options) {
  check_limits(1, timeout);
  const SurfaceSampleParameters parameters = surface_parameters(options_of(options), tolerance);
  const CallableSurface surface(std::move(function), content);
  // Loops in an arena of one slot stay in this thread, which has the GIL.
  Row row;
  oneapi::tbb::task_arena(1).execute([&] {
    row = row_or_failure([&] {
      return surface_row(surface, sample_surface(surface, parameters, token_of(nullptr, timeout)));
    });
  });
  return arrays_of(std::move(row), surface.content_sha256());
}

// ---- measures

double measure_boxes(const py::object& points, const ContentMesh& mesh, std::uint32_t boxes,
                     std::uint64_t seed) {
  if (boxes < 1 || boxes > 200000) throw py::value_error(fmt::format("boxes is {}: 1 to 200000", boxes));
  const std::vector<double> triples = finite_triples(points, "points");
  if (triples.empty()) throw py::value_error("points is empty");
  const py::gil_scoped_release released;
  return box_error(mesh.mesh, triples, boxes, seed, {});
}

void translate(std::exception_ptr error) {
  try {
    std::rethrow_exception(std::move(error));
  } catch (const ItemError& problem) {
    ItemReport report;
    report.status = problem.status();
    report.reason = problem.what();
    const py::object made = sampling_error(report);
    PyErr_SetObject(reinterpret_cast<PyObject*>(Py_TYPE(made.ptr())), made.ptr());
  } catch (const UsageError& problem) {
    PyErr_SetString(PyExc_ValueError, problem.what());
  } catch (const RunError& problem) {
    PyErr_SetString(PyExc_OSError, problem.what());
  }
}

}  // namespace

}  // namespace meander

PYBIND11_MODULE(_core, module) {
  using namespace meander;
  using namespace py::literals;
  module.doc() = "Sampling of surfaces: see the package meander.";
  module.attr("__version__") = meander_version;
  add_sampling_error(module);
  py::register_exception_translator(translate);

  py::class_<ContentMesh, SharedMesh>(module, "Mesh")
      .def_static("read", read_mesh_file, "path"_a)
      .def_static(
          "of_arrays",
          [](py::object vertices, py::object faces, py::object normals, py::object density,
             bool density_of_faces, py::object content, bool check) {
            return std::make_shared<ContentMesh>(
                mesh_of_arrays({vertices, faces, normals, density, density_of_faces, content, check}));
          },
          "vertices"_a, "faces"_a, "normals"_a, "density"_a, "density_of_faces"_a, "content"_a, "check"_a)
      .def_property_readonly("vertices", vertices_of)
      .def_property_readonly("faces", faces_of)
      .def_property_readonly("content",
                             [](const ContentMesh& mesh) {
                               return py::bytes(reinterpret_cast<const char*>(mesh.content.data()),
                                                mesh.content.size());
                             })
      .def("__repr__", [](const ContentMesh& mesh) {
        return fmt::format("<meander.Mesh of {} vertices and {} faces>", mesh.mesh.vertex_count(),
                           mesh.mesh.polygon_count());
      });

  py::class_<Sampler>(module, "Sampler")
      .def(
          py::init([](const py::kwargs& options) { return Sampler(sample_parameters(options_of(options))); }))
      .def("sample_mesh", sample_mesh, "mesh"_a, "threads"_a, "timeout"_a)
      .def("sample_arrays",
           [](const Sampler& sampler, py::object vertices, py::object faces, py::object normals,
              py::object density, bool density_of_faces, py::object content, bool check, int threads,
              std::optional<double> timeout) {
             return sample_arrays(sampler,
                                  {vertices, faces, normals, density, density_of_faces, content, check},
                                  threads, timeout);
           })
      .def("sample_many", sample_many, "meshes"_a, "threads"_a, "timeout"_a);

  module.def("sample_named_surface", sample_named_surface);
  module.def("sample_callable_surface", sample_callable_surface);
  module.def("surface_names", [] {
    std::vector<std::string> names;
    for (const std::string_view name : surface_names()) names.emplace_back(name);
    return names;
  });
  module.def("descriptor_names",
             [] { return std::vector<std::string>(descriptor_names.begin(), descriptor_names.end()); });
  module.def("measure_boxes", measure_boxes, "points"_a, "mesh"_a, "boxes"_a, "seed"_a);
}
