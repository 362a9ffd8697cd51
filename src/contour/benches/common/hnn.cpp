// Processor seconds of the authors' HNN-Crust on points in a file of little-endian doubles, which it takes as floats. It is linked with
// their Reconstruct2D.cpp and with ANN.
#include "Reconstruct2D.h"

#include <ctime>
#include <fstream>
#include <iostream>
#include <vector>

int main(int count, char **arguments) {
  if (count != 2) return 2;
  std::ifstream file(arguments[1], std::ios::binary);
  std::vector<Point> points;
  double place[2];
  while (file.read(reinterpret_cast<char *>(place), sizeof place))
    points.emplace_back(static_cast<float>(place[0]), static_cast<float>(place[1]));
  const std::clock_t start = std::clock();
  Reconstruct2D found(points, true);
  found.reconstruct();
  const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
  std::cout << seconds << ' ' << found.getEdgeMap().size() << std::endl;
}
