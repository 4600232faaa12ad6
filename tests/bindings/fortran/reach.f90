!> What the command can do with files, metrics and meshes, Fortran can: each call once, in an empty folder.
program reach
  use, intrinsic :: iso_c_binding
  use weft
  implicit none
  type(c_ptr) :: mesh = c_null_ptr, other = c_null_ptr, metric = c_null_ptr, options = c_null_ptr, &
    result = c_null_ptr, ball = c_null_ptr, broken = c_null_ptr, filled = c_null_ptr, sizes = c_null_ptr, fields = c_null_ptr, &
    there = c_null_ptr, part = c_null_ptr, made = c_null_ptr
  type(weft_measures) :: measures
  type(weft_fill_settings) :: settings
  type(weft_fill_account) :: filling
  type(weft_component_account) :: account
  character(:), allocatable :: text, why
  integer(c_int64_t) :: count, before, points, outside
  real(c_double) :: complexity, farthest
  real(c_double), pointer :: x(:, :)
  real(c_double), allocatable :: values(:, :)
  integer(c_int), pointer :: owners(:)
  integer(c_int) :: goal_met = -1, cancelled = -1
  integer :: status

  call check(weft_options_create(options))
  call check(weft_options_set(options, "threads", 1))
  call check(weft_mesh_box([3_c_int64_t, 3_c_int64_t, 3_c_int64_t], mesh))
  call check(weft_mesh_box([4_c_int64_t, 4_c_int64_t, 4_c_int64_t], other, max=[1d0, 1d0, 2d0]))

  ! Arrays of wrong sizes are refused by name before they are read.
  if (weft_mesh_create(reshape([(0d0, count=1, 8)], [2, 4]), reshape([1_c_int64_t, 2_c_int64_t, 3_c_int64_t, &
      4_c_int64_t], [4, 1]), ball) /= weft_misuse) error stop "points(2, n)"
  call must_say("points: has 2 rows, not (3, n)")
  if (weft_mesh_create(reshape([(0d0, count=1, 9)], [3, 3]), reshape([1_c_int64_t, 2_c_int64_t, 3_c_int64_t], [3, 1]), &
      ball) /= weft_misuse) error stop "tets(3, m)"
  call must_say("tets: has 3 rows, not (4, m)")
  if (weft_mesh_set(mesh, weft_edges, [1_c_int64_t]) /= weft_misuse) error stop "half an edge"
  call must_say("values: has 1 numbers, not 2 for each entity")
  if (weft_metric_from_tensors(reshape([(1d0, count=1, 9)], [9, 1]), weft_order_sol, metric) /= weft_misuse) &
    error stop "tensors(9, n)"
  call must_say("tensors: has 9 rows, not (6, n)")
  if (weft_part_create(mesh, [1_c_int64_t], c_null_ptr, part) /= weft_misuse) error stop "ids"
  call must_say("point_ids: has 1 ids, not one for each of the 64 points")

  ! Checks and measures.
  call check(weft_mesh_compare(mesh, mesh, count))
  if (count /= 0) error stop "a mesh differs from itself"
  call check(weft_mesh_compare(mesh, other, count))
  if (count == 0 .or. index(weft_error(), "volume of reference 1 is 1") == 0) error stop "no difference is found"
  call sizes_of(mesh, 0.3d0, metric)
  call check(weft_measure(mesh, metric, measures))
  call check(weft_metric_complexity(mesh, metric, complexity))
  if (abs(measures%complexity - complexity) > 1d-9 * complexity) error stop "two complexities"
  call check(weft_stat(mesh, metric, c_null_ptr, text))
  if (index(text, '"schema": "weft-stat-1"') == 0 .or. index(text, "histogram") == 0) error stop "stat"
  call check(weft_draw_histograms("plot.svg", mesh, metric))
  call check(weft_draw("mesh.svg", mesh, metric, color_by="quality", clip="x=0.5", title="a cut", axes=.false.))
  call must_be_there("mesh.svg")
  if (weft_draw("mesh.svg", mesh, c_null_ptr, field=[1d0, 2d0]) == weft_ok) error stop "two values for all points"
  if (weft_draw("mesh.svg", mesh, c_null_ptr, zoom=0d0) /= weft_option_error) error stop "no zoom"

  ! Repair: a mesh with a vertex of no tet.
  call check(weft_mesh_create(reshape([0d0,0d0,0d0, 1d0,0d0,0d0, 0d0,1d0,0d0, 0d0,0d0,1d0, 5d0,5d0,5d0], [3, 5]), &
      reshape([1_c_int64_t, 2_c_int64_t, 3_c_int64_t, 4_c_int64_t], [4, 1]), broken))
  call check(weft_mesh_repair(broken, c_null_ptr, text))
  if (index(text, "unused vertices removed") == 0) error stop "nothing was repaired"
  call check(weft_mesh_num_points(broken, count))
  if (count /= 4) error stop "the vertex is still there"
  call check(weft_free(broken))

  ! Files.
  call check(weft_mesh_write(mesh, "start.meshb"))
  call check(weft_metric_write(metric, "h.solb"))
  call check(weft_options_set(options, "metric", "h.solb"))
  call check(weft_adapt_files("start.meshb", "fine.meshb", options, result, background="start.meshb", &
                              fields=["h.solb"], report="run", page=.false.))
  call check(weft_result_json(result, text))
  if (index(text, "weft-report-1") == 0) error stop "no report"
  call check(weft_result_report(result, text, why))
  if (text /= "run/report.json" .or. why /= "") error stop "the report is not told"
  call check(weft_free(result))
  call must_be_there("fine.meshb")
  call must_be_there("fine-fields.solb")
  call must_be_there("run/report.json")

  ! A recorded run, on another machine too.
  call check(weft_options_set(options, "subdomains", 2))
  call check(weft_adapt_files("start.meshb", "parts.meshb", options, result, report="parts"))
  call check(weft_free(result))
  call check(weft_replay("parts/graph.json", text, why, ranks=2, network="5us,1GB/s", balancer="diffusion", &
                         account="replay.json"))
  if (index(text, '"ranks": 2') == 0 .or. index(why, "diffusion") == 0) error stop "no account of the replay"
  call must_be_there("replay.json")
  if (weft_replay("parts/graph.json", text, ranks=0) /= weft_option_error) error stop "no ranks"
  call check(weft_graph_text("parts/graph.json", "dot", text, round=0, collapse="subdomains"))
  if (index(text, "digraph") == 0) error stop "no task graph"
  if (weft_graph_text("parts/graph.json", "gif", text) /= weft_option_error) error stop "gif"
  call check(weft_report_page("parts/profile.json", "page.html"))
  call must_be_there("page.html")
  call check(weft_compare_reports("parts/profile.json", "run/report.json", text, page="both.html"))
  if (len(text) == 0) error stop "no comparison"
  call must_be_there("both.html")
  call check(weft_options_set(options, "subdomains", 0))
  call check(weft_convert("start.meshb", "start.msh", solution="h.solb", encoding="ascii", msh_version=2))
  call check(weft_convert("start.meshb", "start.stl", dropped=text))
  if (index(text, "tets") == 0) error stop "what an STL file cannot hold is not told"
  if (weft_convert("start.meshb", "start.msh", encoding="utf") /= weft_option_error) error stop "encoding"

  ! Initial meshes.
  call check(weft_ball_surface(1d0, [0d0, 0d0, 0d0], 0.5d0, ball))
  call check(weft_fill_settings_default(settings))
  settings%growth = 1.5d0
  call check(weft_fill(ball, options, filled, sizes, settings))
  call check(weft_mesh_count(filled, weft_tets, before))
  call check(weft_free(sizes))
  call sizes_of(filled, 0.25d0, sizes)
  call check(weft_free(other))
  call check(weft_fill_to_background(ball, filled, sizes, options, other, metric))
  call check(weft_mesh_count(other, weft_tets, count))
  if (count < 2 * before) error stop "the sizes of the background are not used"
  call check(weft_fill_to_result(ball, c_null_ptr, c_null_ptr, options, result))
  call check(weft_result_fill(result, filling))
  if (filling%regions /= 1) error stop "the ball is one region"
  call check(weft_result_told(result, weft_ended_by, text))
  if (text /= "") error stop "nothing has ended it"
  call check(weft_free(result))
  call check(weft_options_set(options, "complexity", 5000))
  call check(weft_options_set(options, "hmin", 0.5d0))
  call check(weft_metric_make_with(mesh, c_null_ptr, options, made, text))
  if (index(text, "instead of 5,000") == 0) error stop "a warning is lost"
  call check(weft_options_set(options, "complexity", 0))
  call check(weft_options_set(options, "hmin", 0d0))
  call check(weft_free(made))
  if (weft_tessellate(options, 0d0, other) /= weft_option_error) error stop "a model that is not named"

  ! Fields.
  call check(weft_mesh_num_points(mesh, points))
  call check(weft_mesh_points(mesh, x))
  values = x
  call check(weft_fields_create(points, fields))
  if (weft_fields_add(fields, "place", values(:, 2:)) /= weft_misuse) error stop "a point too few"
  call must_say("place: has 63 columns, not one for each of the 64 points")
  call check(weft_fields_add(fields, "place", values))
  call check(weft_interpolate(mesh, fields, filled, options, there))
  call check(weft_fields_outside(there, outside, farthest))
  if (outside == 0 .or. farthest <= 0) error stop "a ball of radius 1 lies in the unit cube"
  call check(weft_fields_account(there, 2, account, text))
  if (text /= "place 2" .or. abs(account%integral_before - 0.5d0) > 1d-12) error stop "accounts"
  call check(weft_fields_write(fields, "place.solb"))
  call check(weft_free(fields))
  call check(weft_fields_read("place.solb", fields))

  ! Parts.
  call check(weft_part_create(mesh, [(count, count=1, points)], c_null_ptr, part))
  call check(weft_part_ghosts(part, count, owners))
  if (count /= 162 .or. associated(owners)) error stop "ghosts of a part that has none"

  ! A run that is ended early is measured when that is asked for.
  call check(weft_options_cancel(options, 1))
  call check(weft_adapt(mesh, c_null_ptr, options, c_null_ptr, result))
  call check(weft_result_verdict(result, goal_met, cancelled))
  if (goal_met /= 0 .or. cancelled /= 1) error stop "it is not cancelled"
  call check(weft_result_measures(result, measures))
  if (abs(measures%volume - 1) > 1d-12) error stop "it is not measured"
  call check(weft_free(result))
  call check(weft_options_checkpoint(options))
  status = weft_free(mesh) + weft_free(other) + weft_free(metric) + weft_free(options) + weft_free(ball) + &
    weft_free(filled) + weft_free(sizes) + weft_free(fields) + weft_free(there) + weft_free(part)
  print "(a)", "reached"

contains

  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status == weft_ok) return
    print "(a)", weft_error()
    error stop 1
  end subroutine check

  subroutine must_say(text)
    character(*), intent(in) :: text
    if (weft_error() == text) return
    print "(4a)", "'", weft_error(), "' is not ", text
    error stop 1
  end subroutine must_say

  subroutine must_be_there(file)
    character(*), intent(in) :: file
    logical :: there
    inquire (file=file, exist=there)
    if (there) return
    print "(2a)", file, " has not been written"
    error stop 1
  end subroutine must_be_there

  !> Metrics of one size.
  subroutine sizes_of(mesh, size, metric)
    type(c_ptr), intent(in) :: mesh
    real(c_double), intent(in) :: size
    type(c_ptr), intent(inout) :: metric
    integer(c_int64_t) :: points
    real(c_double), allocatable :: all(:)
    call check(weft_mesh_num_points(mesh, points))
    allocate (all(points))
    all = size
    call check(weft_metric_from_sizes(all, metric))
  end subroutine sizes_of
end program reach
