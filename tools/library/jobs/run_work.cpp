// Costs of a tet, in the units of meshing/adapt/work.h; measured on the same cases.
#include "tools/library/jobs/run_work.h"

#include "meshing/adapt/work.h"

namespace weft::tools {

RunWork::RunWork(double tets, double wanted, bool has_fields) : has_fields_(has_fields) {
  constexpr double kRead = 0.05, kMetric = 0.12, kMeasure = 0.5;
  metric_ = kMetric * tets;
  measure_ = kMeasure * tets;
  before_ = kRead * tets + metric_ + measure_;
  adapt_ = meshing::predict_work(tets, wanted).sum();
  predict_after(wanted);
}

/// What has been said of the adaptation stays as it is.
void RunWork::adapted(double tets) { predict_after(tets); }

void RunWork::predict_after(double tets) {
  constexpr double kMeasure = 0.55, kFields = 1, kWrite = 0.12;
  measure_after_ = kMeasure * tets;
  fields_ = has_fields_ ? kFields * tets : 0;
  write_ = kWrite * tets;
}

}  // namespace weft::tools
