// The program of the top README, word for word: tests build and run it, so that it stays true.
#include <weft/weft.h>

int main() {
  const weft::Mesh mesh = weft::read_mesh("wing.meshb");
  weft::Options options;
  options.metric.complexity = 5000;
  options.run.threads = 8;
  const weft::Result fine = weft::adapt(mesh, weft::read_metric("wing.solb", mesh), options);
  weft::write_result("fine.meshb", fine.mesh, fine.metric);
}
