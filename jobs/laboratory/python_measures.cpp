// The measures of the Python module (jobs/python/measures.h).
#include <fmt/format.h>
#include <oneapi/tbb/global_control.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "jobs/laboratory/functions/laboratory_functions.h"
#include "jobs/python/measures.h"
#include "kernels/analyse/box_discrepancy.h"
#include "kernels/mesh/prepare_mesh.h"
#include "kernels/sample/point_frames.h"

namespace meander {

double box_error(const PolygonMesh& mesh, std::span<const double> points, std::uint32_t boxes,
                 std::uint64_t seed, const CancelToken& cancel) {
  const PreparedMesh surface = prepare_mesh(mesh, cancel);
  BoxParameters parameters;
  parameters.boxes = boxes;
  parameters.seed = seed;
  const std::vector<RotatedBox> shapes =
      random_boxes(surface.x, surface.y, surface.z, surface.triangles, parameters);
  if (shapes.empty())
    throw ItemError(Status::zero_area, "hardly any box holds between 0.2 % and 60 % of the surface");
  std::vector<double> working;
  working.reserve(points.size());
  for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
    const Vector3 p = to_working(surface, {points[i], points[i + 1], points[i + 2]});
    working.insert(working.end(), {p.x, p.y, p.z});
  }
  return box_error_ratio(shapes, working);
}

namespace {

// threads: of all later calls, up to 1024. For programs: nothing takes it back.
LaboratoryResult limit_threads(const LaboratoryArguments& given) {
  using oneapi::tbb::global_control;
  static std::unique_ptr<global_control> limit;
  const std::uint64_t threads = given.whole("threads");
  if (threads < 1 || threads > 1024) throw std::invalid_argument("threads must be 1 to 1024");
  limit.reset();
  limit = std::make_unique<global_control>(global_control::max_allowed_parallelism, threads);
  return {};
}

constexpr LaboratoryFunction own_functions[] = {{"limit_threads", limit_threads}};

}  // namespace

LaboratoryResult call_laboratory(std::string_view name, const LaboratoryArguments& arguments) {
  for (const std::span<const LaboratoryFunction> functions :
       {std::span<const LaboratoryFunction>(own_functions), histogram_functions, measure_functions,
        model_functions, picture_functions, plane_functions, splat_functions, surface_functions,
        tensor_functions})
    for (const LaboratoryFunction& function : functions)
      if (name == function.name) return function.call(arguments);
  throw std::invalid_argument(fmt::format("the laboratory has no function `{}`", name));
}

}  // namespace meander
