// Processor seconds of CGAL on points in a file of little-endian doubles: `alpha FILE MM` makes the alpha-shape and lists the edges
// of its border, `connecting FILE 0` looks for the smallest alpha of one part with all points, `delaunay FILE 0` triangulates,
// `transport FILE VERTICES` leaves so many vertices.
#include <CGAL/Alpha_shape_2.h>
#include <CGAL/Alpha_shape_face_base_2.h>
#include <CGAL/Alpha_shape_vertex_base_2.h>
#include <CGAL/Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Optimal_transportation_reconstruction_2.h>

#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_2;
using Vertex = CGAL::Alpha_shape_vertex_base_2<Kernel>;
using Face = CGAL::Alpha_shape_face_base_2<Kernel>;
using Mesh = CGAL::Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;
using Shape = CGAL::Alpha_shape_2<Mesh>;

int main(int count, char **arguments) {
  if (count != 4) return 2;
  std::ifstream file(arguments[2], std::ios::binary);
  const std::string work = arguments[1];
  const double value = std::stod(arguments[3]);
  std::vector<Point> points;
  double place[2];
  while (file.read(reinterpret_cast<char *>(place), sizeof place)) points.emplace_back(place[0], place[1]);
  const std::clock_t start = std::clock();
  std::size_t made = 0;
  double seconds = 0;
  const auto stop = [&] { seconds = double(std::clock() - start) / CLOCKS_PER_SEC; };
  if (work == "alpha") {
    const Shape shape(points.begin(), points.end(), value * value, Shape::REGULARIZED);
    made = std::distance(shape.alpha_shape_edges_begin(), shape.alpha_shape_edges_end());
    stop();
  } else if (work == "connecting") {
    Shape shape(points.begin(), points.end(), 0, Shape::REGULARIZED);
    shape.set_alpha(*shape.find_optimal_alpha(1));
    made = std::distance(shape.alpha_shape_edges_begin(), shape.alpha_shape_edges_end());
    stop();
  } else if (work == "transport") {
    CGAL::Optimal_transportation_reconstruction_2<Kernel> found(points);
    found.run_until(static_cast<unsigned>(value));
    made = 1;
    stop();
  } else {
    const CGAL::Delaunay_triangulation_2<Kernel> mesh(points.begin(), points.end());
    made = mesh.number_of_faces();
    stop();
  }
  std::cout << seconds << ' ' << made << std::endl;
  return made > 0 ? 0 : 1;
}
