// Signed distances by libigl, for distance_peers.py --libigl:
//   libigl_distances VERTICES FACES POINTS DISTANCES
// VERTICES and POINTS: n x 3 float64; FACES: m x 3 int32; writes a float64 for each point to DISTANCES and
// prints the processor seconds that trees and points took. Sides by fast winding numbers (Barill et al.
// 2018), as igl::signed_distance takes them. Compiled with the folder of libigl's headers (MPL 2.0) as
// include path.
#include <igl/signed_distance.h>

#include <cstdint>
#include <cstdio>
#include <ctime>
#include <string>

namespace {

template <class Matrix>
Matrix read(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return {};
  std::fseek(file, 0, SEEK_END);
  const long rows = std::ftell(file) / static_cast<long>(3 * sizeof(typename Matrix::Scalar));
  std::rewind(file);
  Matrix values(rows, 3);
  const std::size_t read = std::fread(values.data(), sizeof(typename Matrix::Scalar), values.size(), file);
  std::fclose(file);
  return static_cast<long>(read) == values.size() ? values : Matrix();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  using Faces = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const Points vertices = read<Points>(argv[1]), points = read<Points>(argv[3]);
  const Faces faces = read<Faces>(argv[2]);
  if (vertices.rows() == 0 || faces.rows() == 0 || points.rows() == 0) return 1;
  const Eigen::MatrixXd of_vertices = vertices, of_points = points;
  const Eigen::MatrixXi of_faces = faces;
  const std::clock_t start = std::clock();
  Eigen::VectorXd distances;
  Eigen::VectorXi nearest;
  Eigen::MatrixXd places, normals;
  igl::signed_distance(of_points, of_vertices, of_faces, igl::SIGNED_DISTANCE_TYPE_FAST_WINDING_NUMBER,
                       distances, nearest, places, normals);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::FILE* file = std::fopen(argv[4], "wb");
  const auto count = static_cast<std::size_t>(distances.size());
  if (file == nullptr || std::fwrite(distances.data(), sizeof(double), count, file) != count) return 1;
  std::fclose(file);
  std::printf("%.6f\n", seconds);
}
