// What the examples in other languages do, in C++: adapt_file IN.meshb METRIC.solb OUT.meshb
#include <weft/weft.h>

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const weft::Mesh mesh = weft::read_mesh(argv[1]);
  weft::Options options;
  options.run.threads = 1;
  options.metric.hgrad = 1.5;
  const weft::Result fine = weft::adapt(mesh, weft::read_metric(argv[2], mesh), options);
  weft::write_result(argv[3], fine.mesh, fine.metric);
  return 0;
}
