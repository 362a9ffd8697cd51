// Processor seconds of CGAL on points in a file of little-endian doubles: `front FILE` reconstructs by the advancing front,
// `delaunay FILE` triangulates in bulk.
#include <CGAL/Advancing_front_surface_reconstruction.h>
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <array>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

int main(int count, char **arguments) {
  if (count != 3) return 2;
  std::ifstream file(arguments[2], std::ios::binary);
  std::vector<Point> points;
  double place[3];
  while (file.read(reinterpret_cast<char *>(place), sizeof place)) points.emplace_back(place[0], place[1], place[2]);
  const std::clock_t start = std::clock();
  std::size_t made = 0;
  if (std::string(arguments[1]) == "front") {
    std::vector<std::array<std::size_t, 3>> facets;
    CGAL::advancing_front_surface_reconstruction(points.begin(), points.end(), std::back_inserter(facets));
    made = facets.size();
  } else {
    made = CGAL::Delaunay_triangulation_3<Kernel>(points.begin(), points.end()).number_of_finite_cells();
  }
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  std::cout << seconds << std::endl;
  return made > 0 ? 0 : 1;
}
