!> weft adapts tetrahedral meshes to anisotropic metric fields: the C interface <weft/weft-c.h> in Fortran.
!>
!> Every function returns a status, weft_ok (0) where all went well; weft_error() says in words what did not.
!> Objects are of type(c_ptr), c_null_ptr before they are made, and freed by weft_free. Arrays are points(3, n),
!> tets(4, m), triangles(3, k), edges(2, l); indices count from 1, ids of parts as the program likes.
module weft
  use, intrinsic :: iso_c_binding
  implicit none
  private

  integer(c_int), parameter, public :: weft_ok = 0, weft_misuse = 1, weft_input_error = 2, weft_option_error = 3, &
    weft_run_error = 4, weft_out_of_memory = 5, weft_internal_error = 6
  !> Which components of a symmetric tensor are where: 11 12 22 13 23 33; 11 12 13 22 23 33; 11 22 33 23 13 12.
  integer(c_int), parameter, public :: weft_order_sol = 1, weft_order_rows = 2, weft_order_voigt = 3
  !> Arrays of a mesh, for weft_mesh_set, weft_mesh_count and weft_mesh_get.
  integer(c_int), parameter, public :: weft_tets = 0, weft_tet_refs = 1, weft_triangles = 2, weft_triangle_refs = 3, &
    weft_edges = 4, weft_edge_refs = 5, weft_point_refs = 6, weft_corners = 7, weft_required_points = 8, &
    weft_ridges = 9, weft_required_edges = 10, weft_required_triangles = 11
  !> What weft_result_told tells: warnings, what repair has done, why the goal was not met, what has ended the run early.
  integer(c_int), parameter, public :: weft_warnings = 0, weft_mends = 1, weft_missed = 2, weft_ended_by = 3

  !> Quality of tets (mean ratio) and lengths of edges in a metric.
  type, bind(c), public :: weft_measures
    integer(c_size_t) :: size
    integer(c_int64_t) :: vertices, tets, edges, triangles
    real(c_double) :: volume, complexity, quality_mean, quality_min, quality_q01, length_mean, length_min, &
      length_max, edges_unit, edges_short, edges_long
  end type weft_measures

  !> What became of one component of a field that weft_interpolate has transferred.
  type, bind(c), public :: weft_component_account
    integer(c_size_t) :: size
    type(c_ptr) :: name
    real(c_double) :: integral_before, integral_after, absolute, difference_l2, norm_l2, difference_max, norm_max, &
      beyond_bounds
  end type weft_component_account

  !> How weft_fill fills: weft_fill_settings_default gives the defaults.
  type, bind(c), public :: weft_fill_settings
    integer(c_size_t) :: size
    real(c_double) :: growth, max_size, merge
    integer(c_int32_t) :: materials, remesh_surface
  end type weft_fill_settings

  !> What weft_fill_to_result has done.
  type, bind(c), public :: weft_fill_account
    integer(c_size_t) :: size
    integer(c_int64_t) :: regions
    real(c_double) :: deviation, grid_seconds, fill_seconds
  end type weft_fill_account

  type, bind(c) :: file_settings
    integer(c_size_t) :: size
    type(c_ptr) :: background, fields
    integer(c_int64_t) :: num_fields
    type(c_ptr) :: report
    integer(c_int32_t) :: page
    type(c_ptr) :: case_name, graph, trace
    integer(c_int32_t) :: simulate_ranks
    type(c_ptr) :: simulate_network
    real(c_double) :: simulate_slowdown
    integer(c_int32_t) :: simulate_cores
  end type file_settings

  type, bind(c) :: write_settings
    integer(c_size_t) :: size
    type(c_ptr) :: encoding
    integer(c_int32_t) :: msh_version, compress, pieces
  end type write_settings

  type, bind(c) :: replay_settings
    integer(c_size_t) :: size
    integer(c_int32_t) :: ranks, threads
    type(c_ptr) :: network, balancer
    real(c_double) :: slowdown, grow
    integer(c_int64_t) :: subdomain_bytes
    integer(c_int32_t) :: processor_times, copies, split, unused
    type(c_ptr) :: report, account, trace
  end type replay_settings

  type, bind(c) :: picture_settings
    integer(c_size_t) :: size
    type(c_ptr) :: color_by, pixels, from, up, clip, focus, range, title, only
    integer(c_int64_t) :: num_only
    real(c_double) :: zoom, line_width
    integer(c_int32_t) :: dark, flip, slice, edges, legend, axes
  end type picture_settings

  type, bind(c) :: graph_filter
    integer(c_size_t) :: size
    integer(c_int64_t) :: round, subdomain
    type(c_ptr) :: collapse
    integer(c_int32_t) :: critical_path, plan
  end type graph_filter

  !> How far a run is: what a function of weft_set_progress is told.
  type, bind(c), public :: weft_progress
    integer(c_size_t) :: size
    type(c_ptr) :: stage
    real(c_double) :: done
    integer(c_int64_t) :: tets
  end type weft_progress

  abstract interface
    !> Returns 0 to cancel: the run ends soon with the valid mesh that it has.
    function weft_progress_function(user, progress) bind(c) result(go_on)
      import :: c_ptr, c_int, weft_progress
      type(c_ptr), value :: user
      type(weft_progress), intent(in) :: progress
      integer(c_int) :: go_on
    end function weft_progress_function
  end interface
  public :: weft_progress_function

  public :: weft_error, weft_free, weft_mesh_create, weft_mesh_set, weft_mesh_num_points, weft_mesh_count, &
    weft_mesh_get, weft_mesh_points, weft_mesh_read, weft_mesh_write, weft_mesh_verify, weft_metric_from_sizes, &
    weft_metric_from_tensors, weft_metric_read, weft_metric_write, weft_metric_make, weft_metric_get, &
    weft_fields_create, weft_fields_add, weft_fields_get, weft_interpolate, weft_options_create, weft_options_set, &
    weft_options_add_solution, weft_set_progress, weft_adapt, weft_adapt_parts, weft_part_create, weft_part_mesh, &
    weft_part_fields, weft_part_points, weft_result_mesh, weft_result_metric, weft_result_fields, weft_result_part, &
    weft_result_write, weft_result_verdict, weft_result_measures, weft_result_summary, weft_fill, &
    weft_adapt_to_background, weft_adapt_parts_to_background, weft_adapt_files, weft_convert, weft_mesh_box, &
    weft_mesh_compare, weft_metric_complexity, weft_fields_read, weft_fields_write, weft_fields_account, &
    weft_fields_outside, weft_options_cancel, weft_options_checkpoint, weft_part_ghosts, weft_result_json, &
    weft_result_report, weft_result_told, weft_result_fill, weft_fill_to_result, weft_metric_make_with, &
    weft_measure, weft_stat, weft_draw_histograms, weft_fill_settings_default, weft_fill_to_background, &
    weft_tessellate, weft_ball_surface, weft_cylinder_surface, weft_delta_wing_surface, weft_mesh_repair, &
    weft_fields_repair_metric, weft_surface_repair, weft_replay, weft_graph_text, weft_report_page, &
    weft_compare_reports, weft_draw

  interface weft_options_set
    module procedure options_set_text, options_set_real, options_set_integer
  end interface weft_options_set

  interface
    function c_last_error() bind(c, name="weft_last_error")
      import; type(c_ptr) :: c_last_error
    end function
    !> Frees any object; c_null_ptr is allowed.
    function weft_free(handle) bind(c)
      import; type(c_ptr), value :: handle; integer(c_int) :: weft_free
    end function
    function c_refuse(why) bind(c, name="weft_refuse")
      import; character(c_char), intent(in) :: why(*); integer(c_int) :: c_refuse
    end function
    function c_mesh_create(num_points, points, num_tets, tets, mesh) bind(c, name="weft_mesh_create")
      import; integer(c_int64_t), value :: num_points, num_tets; real(c_double), intent(in) :: points(*)
      integer(c_int64_t), intent(in) :: tets(*); type(c_ptr), intent(inout) :: mesh; integer(c_int) :: c_mesh_create
    end function
    function c_mesh_set(mesh, which, count, values) bind(c, name="weft_mesh_set")
      import; type(c_ptr), value :: mesh; integer(c_int), value :: which; integer(c_int64_t), value :: count
      integer(c_int64_t), intent(in) :: values(*); integer(c_int) :: c_mesh_set
    end function
    function weft_mesh_num_points(mesh, count) bind(c)
      import; type(c_ptr), value :: mesh; integer(c_int64_t), intent(inout) :: count
      integer(c_int) :: weft_mesh_num_points
    end function
    !> Rows of an array: weft_tets, weft_triangles, ...
    function weft_mesh_count(mesh, which, count) bind(c)
      import; type(c_ptr), value :: mesh; integer(c_int), value :: which; integer(c_int64_t), intent(inout) :: count
      integer(c_int) :: weft_mesh_count
    end function
    function c_mesh_get(mesh, which, capacity, values) bind(c, name="weft_mesh_get")
      import; type(c_ptr), value :: mesh; integer(c_int), value :: which; integer(c_int64_t), value :: capacity
      integer(c_int64_t), intent(inout) :: values(*); integer(c_int) :: c_mesh_get
    end function
    function c_mesh_points(mesh, points) bind(c, name="weft_mesh_points")
      import; type(c_ptr), value :: mesh; type(c_ptr), intent(inout) :: points; integer(c_int) :: c_mesh_points
    end function
    function c_mesh_read(path, mesh) bind(c, name="weft_mesh_read")
      import; character(c_char), intent(in) :: path(*); type(c_ptr), intent(inout) :: mesh; integer(c_int) :: c_mesh_read
    end function
    function c_mesh_write(mesh, path) bind(c, name="weft_mesh_write")
      import; type(c_ptr), value :: mesh; character(c_char), intent(in) :: path(*); integer(c_int) :: c_mesh_write
    end function
    !> num_problems is 0 for a mesh that conforms; else weft_error() names some.
    function weft_mesh_verify(mesh, num_problems, volume) bind(c)
      import; type(c_ptr), value :: mesh; integer(c_int64_t), intent(inout) :: num_problems
      real(c_double), intent(inout) :: volume; integer(c_int) :: weft_mesh_verify
    end function
    function c_metric_from_sizes(count, sizes, metric) bind(c, name="weft_metric_from_sizes")
      import; integer(c_int64_t), value :: count; real(c_double), intent(in) :: sizes(*)
      type(c_ptr), intent(inout) :: metric; integer(c_int) :: c_metric_from_sizes
    end function
    function c_metric_from_tensors(count, tensors, order, metric) bind(c, name="weft_metric_from_tensors")
      import; integer(c_int64_t), value :: count; real(c_double), intent(in) :: tensors(*)
      integer(c_int), value :: order; type(c_ptr), intent(inout) :: metric; integer(c_int) :: c_metric_from_tensors
    end function
    function c_metric_read(path, mesh, metric) bind(c, name="weft_metric_read")
      import; character(c_char), intent(in) :: path(*); type(c_ptr), value :: mesh
      type(c_ptr), intent(inout) :: metric; integer(c_int) :: c_metric_read
    end function
    function c_metric_write(metric, path) bind(c, name="weft_metric_write")
      import; type(c_ptr), value :: metric; character(c_char), intent(in) :: path(*); integer(c_int) :: c_metric_write
    end function
    !> The metric that options ask for; `source` may be c_null_ptr.
    function weft_metric_make(mesh, source, options, metric) bind(c)
      import; type(c_ptr), value :: mesh, source, options; type(c_ptr), intent(inout) :: metric
      integer(c_int) :: weft_metric_make
    end function
    function c_metric_get(metric, order, capacity, tensors) bind(c, name="weft_metric_get")
      import; type(c_ptr), value :: metric; integer(c_int), value :: order; integer(c_int64_t), value :: capacity
      real(c_double), intent(inout) :: tensors(*); integer(c_int) :: c_metric_get
    end function
    function c_fields_create(num_points, fields) bind(c, name="weft_fields_create")
      import; integer(c_int64_t), value :: num_points; type(c_ptr), intent(inout) :: fields
      integer(c_int) :: c_fields_create
    end function
    function c_fields_add(fields, name, components, values) bind(c, name="weft_fields_add")
      import; type(c_ptr), value :: fields; character(c_char), intent(in) :: name(*); integer(c_int), value :: components
      real(c_double), intent(in) :: values(*); integer(c_int) :: c_fields_add
    end function
    function c_fields_count(fields, num_fields, num_points) bind(c, name="weft_fields_count")
      import; type(c_ptr), value :: fields; integer(c_int64_t), intent(inout) :: num_fields, num_points
      integer(c_int) :: c_fields_count
    end function
    function c_fields_get(fields, index, name, components, values) bind(c, name="weft_fields_get")
      import; type(c_ptr), value :: fields; integer(c_int64_t), value :: index
      type(c_ptr), intent(inout) :: name, values; integer(c_int), intent(inout) :: components
      integer(c_int) :: c_fields_get
    end function
    !> Fields of one mesh at the vertices of another; options may be c_null_ptr.
    function weft_interpolate(from, fields, to, options, result) bind(c)
      import; type(c_ptr), value :: from, fields, to, options; type(c_ptr), intent(inout) :: result
      integer(c_int) :: weft_interpolate
    end function
    function c_options_create(settings, options) bind(c, name="weft_options_create")
      import; type(c_ptr), value :: settings; type(c_ptr), intent(inout) :: options; integer(c_int) :: c_options_create
    end function
    function c_options_set(options, name, value) bind(c, name="weft_options_set")
      import; type(c_ptr), value :: options; character(c_char), intent(in) :: name(*), value(*)
      integer(c_int) :: c_options_set
    end function
    function c_options_set_number(options, name, value) bind(c, name="weft_options_set_number")
      import; type(c_ptr), value :: options; character(c_char), intent(in) :: name(*); real(c_double), value :: value
      integer(c_int) :: c_options_set_number
    end function
    !> The scalar fields of a solution drive the metric.
    function weft_options_add_solution(options, solution) bind(c)
      import; type(c_ptr), value :: options, solution; integer(c_int) :: weft_options_add_solution
    end function
    function c_options_set_progress(options, function, user) bind(c, name="weft_options_set_progress")
      import; type(c_ptr), value :: options, user; type(c_funptr), value :: function
      integer(c_int) :: c_options_set_progress
    end function
    !> metric: at the vertices of the mesh, or c_null_ptr where options make one; options and fields may be c_null_ptr.
    function weft_adapt(mesh, metric, options, fields, result) bind(c)
      import; type(c_ptr), value :: mesh, metric, options, fields; type(c_ptr), intent(inout) :: result
      integer(c_int) :: weft_adapt
    end function
    !> All ranks of a communicator of mpif.h or module mpi (comm%mpi_val of mpi_f08) call it; all get the same status.
    !> `metric`: at the points of the part, or c_null_ptr on all ranks: options make one.
    function weft_adapt_parts(communicator, part, metric, options, result) bind(c, name="weft_adapt_parts_f")
      import; integer(c_int), value :: communicator; type(c_ptr), value :: part, metric, options
      type(c_ptr), intent(inout) :: result; integer(c_int) :: weft_adapt_parts
    end function
    function c_part_create(mesh, point_ids, tet_ids, fields, part) bind(c, name="weft_part_create")
      import; type(c_ptr), value :: mesh, tet_ids, fields; integer(c_int64_t), intent(in) :: point_ids(*)
      type(c_ptr), intent(inout) :: part; integer(c_int) :: c_part_create
    end function
    function weft_part_mesh(part, mesh) bind(c)
      import; type(c_ptr), value :: part; type(c_ptr), intent(inout) :: mesh; integer(c_int) :: weft_part_mesh
    end function
    function weft_part_fields(part, fields) bind(c)
      import; type(c_ptr), value :: part; type(c_ptr), intent(inout) :: fields; integer(c_int) :: weft_part_fields
    end function
    function c_part_points(part, ids, owners) bind(c, name="weft_part_points")
      import; type(c_ptr), value :: part; type(c_ptr), intent(inout) :: ids, owners; integer(c_int) :: c_part_points
    end function
    function weft_result_mesh(result, mesh) bind(c)
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: mesh; integer(c_int) :: weft_result_mesh
    end function
    function weft_result_metric(result, metric) bind(c)
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: metric; integer(c_int) :: weft_result_metric
    end function
    function weft_result_fields(result, fields) bind(c)
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: fields; integer(c_int) :: weft_result_fields
    end function
    function weft_result_part(result, part) bind(c)
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: part; integer(c_int) :: weft_result_part
    end function
    function c_result_write(result, path) bind(c, name="weft_result_write")
      import; type(c_ptr), value :: result; character(c_char), intent(in) :: path(*); integer(c_int) :: c_result_write
    end function
    function weft_result_verdict(result, goal_met, cancelled) bind(c)
      import; type(c_ptr), value :: result; integer(c_int), intent(inout) :: goal_met, cancelled
      integer(c_int) :: weft_result_verdict
    end function
    function c_result_measures(result, measures) bind(c, name="weft_result_measures")
      import; type(c_ptr), value :: result; type(weft_measures), intent(inout) :: measures
      integer(c_int) :: c_result_measures
    end function
    function c_result_summary(result, text) bind(c, name="weft_result_summary")
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: text; integer(c_int) :: c_result_summary
    end function
    !> To a metric at the vertices of `background`, another mesh of the same domain; c_null_ptr: options make one there.
    function weft_adapt_to_background(mesh, background, metric, options, fields, result) bind(c)
      import; type(c_ptr), value :: mesh, background, metric, options, fields; type(c_ptr), intent(inout) :: result
      integer(c_int) :: weft_adapt_to_background
    end function
    !> The same in parts: `background` is a part too, any tets of it on any rank. What is wrong with it is said with
    !> "background: " before the rank.
    function weft_adapt_parts_to_background(communicator, part, background, metric, options, result) &
      bind(c, name="weft_adapt_parts_to_background_f")
      import; integer(c_int), value :: communicator; type(c_ptr), value :: part, background, metric, options
      type(c_ptr), intent(inout) :: result; integer(c_int) :: weft_adapt_parts_to_background
    end function
    function c_file_settings_default(settings) bind(c, name="weft_file_settings_default")
      import; type(file_settings), intent(inout) :: settings; integer(c_int) :: c_file_settings_default
    end function
    function c_adapt_files_with(input, output, settings, options, result) bind(c, name="weft_adapt_files_with")
      import; character(c_char), intent(in) :: input(*), output(*); type(file_settings), intent(in) :: settings
      type(c_ptr), value :: options; type(c_ptr), intent(inout) :: result; integer(c_int) :: c_adapt_files_with
    end function
    function c_write_settings_default(settings) bind(c, name="weft_write_settings_default")
      import; type(write_settings), intent(inout) :: settings; integer(c_int) :: c_write_settings_default
    end function
    function c_convert(input, output, solution, settings, dropped) bind(c, name="weft_convert")
      import; character(c_char), intent(in) :: input(*), output(*), solution(*)
      type(write_settings), intent(in) :: settings; type(c_ptr), intent(inout) :: dropped; integer(c_int) :: c_convert
    end function
    function c_text_get(text, letters) bind(c, name="weft_text_get")
      import; type(c_ptr), value :: text; type(c_ptr), intent(inout) :: letters; integer(c_int) :: c_text_get
    end function
    function c_mesh_box_between(cells, min, max, mesh) bind(c, name="weft_mesh_box_between")
      import; integer(c_int64_t), intent(in) :: cells(3); real(c_double), intent(in) :: min(3), max(3)
      type(c_ptr), intent(inout) :: mesh; integer(c_int) :: c_mesh_box_between
    end function
    !> num_differences is 0 where volumes, areas and touching agree; else weft_error() says how they differ.
    function weft_mesh_compare(mesh, other, num_differences) bind(c)
      import; type(c_ptr), value :: mesh, other; integer(c_int64_t), intent(inout) :: num_differences
      integer(c_int) :: weft_mesh_compare
    end function
    !> About half the vertices of a mesh that conforms to the metric.
    function weft_metric_complexity(mesh, metric, complexity) bind(c)
      import; type(c_ptr), value :: mesh, metric; real(c_double), intent(inout) :: complexity
      integer(c_int) :: weft_metric_complexity
    end function
    function c_fields_read(path, fields) bind(c, name="weft_fields_read")
      import; character(c_char), intent(in) :: path(*); type(c_ptr), intent(inout) :: fields
      integer(c_int) :: c_fields_read
    end function
    function c_fields_write(fields, path) bind(c, name="weft_fields_write")
      import; type(c_ptr), value :: fields; character(c_char), intent(in) :: path(*); integer(c_int) :: c_fields_write
    end function
    function c_fields_account(fields, index, account) bind(c, name="weft_fields_account")
      import; type(c_ptr), value :: fields; integer(c_int64_t), value :: index
      type(weft_component_account), intent(inout) :: account; integer(c_int) :: c_fields_account
    end function
    !> Of interpolated fields: vertices outside the old mesh, and how far the farthest is.
    function weft_fields_outside(fields, vertices, farthest) bind(c)
      import; type(c_ptr), value :: fields; integer(c_int64_t), intent(inout) :: vertices
      real(c_double), intent(inout) :: farthest; integer(c_int) :: weft_fields_outside
    end function
    !> 1 cancels the runs that these options have been given to, from another thread; 0 makes them usable again.
    function weft_options_cancel(options, cancel) bind(c)
      import; type(c_ptr), value :: options; integer(c_int), value :: cancel; integer(c_int) :: weft_options_cancel
    end function
    !> Asks the run that these options have been given to for a checkpoint now, from another thread.
    function weft_options_checkpoint(options) bind(c)
      import; type(c_ptr), value :: options; integer(c_int) :: weft_options_checkpoint
    end function
    function c_part_ghosts(part, num_own_tets, owners) bind(c, name="weft_part_ghosts")
      import; type(c_ptr), value :: part; integer(c_int64_t), intent(inout) :: num_own_tets
      type(c_ptr), intent(inout) :: owners; integer(c_int) :: c_part_ghosts
    end function
    function c_result_json(result, text) bind(c, name="weft_result_json")
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: text; integer(c_int) :: c_result_json
    end function
    function c_result_report(result, report, error) bind(c, name="weft_result_report")
      import; type(c_ptr), value :: result; type(c_ptr), intent(inout) :: report, error
      integer(c_int) :: c_result_report
    end function
    function c_result_told(result, what, text) bind(c, name="weft_result_told")
      import; type(c_ptr), value :: result; integer(c_int), value :: what; type(c_ptr), intent(inout) :: text
      integer(c_int) :: c_result_told
    end function
    function c_result_fill(result, account) bind(c, name="weft_result_fill")
      import; type(c_ptr), value :: result; type(weft_fill_account), intent(inout) :: account
      integer(c_int) :: c_result_fill
    end function
    function c_fill_to_result(surface, background, sizes, settings, options, result) bind(c, name="weft_fill_to_result")
      import; type(c_ptr), value :: surface, background, sizes, settings, options; type(c_ptr), intent(inout) :: result
      integer(c_int) :: c_fill_to_result
    end function
    function c_metric_make_with(mesh, source, options, metric, warnings) bind(c, name="weft_metric_make_with")
      import; type(c_ptr), value :: mesh, source, options; type(c_ptr), intent(inout) :: metric, warnings
      integer(c_int) :: c_metric_make_with
    end function
    function c_measure(mesh, metric, measures) bind(c, name="weft_measure")
      import; type(c_ptr), value :: mesh, metric; type(weft_measures), intent(inout) :: measures
      integer(c_int) :: c_measure
    end function
    function c_stat(mesh, metric, options, json) bind(c, name="weft_stat")
      import; type(c_ptr), value :: mesh, metric, options; type(c_ptr), intent(inout) :: json; integer(c_int) :: c_stat
    end function
    function c_mesh_repair(mesh, fields, mends) bind(c, name="weft_mesh_repair")
      import; type(c_ptr), value :: mesh, fields; type(c_ptr), intent(inout) :: mends; integer(c_int) :: c_mesh_repair
    end function
    function c_fields_repair_metric(fields, mesh, mends) bind(c, name="weft_fields_repair_metric")
      import; type(c_ptr), value :: fields, mesh; type(c_ptr), intent(inout) :: mends
      integer(c_int) :: c_fields_repair_metric
    end function
    function c_surface_repair(surface, mends) bind(c, name="weft_surface_repair")
      import; type(c_ptr), value :: surface; type(c_ptr), intent(inout) :: mends; integer(c_int) :: c_surface_repair
    end function
    function c_replay_settings_default(settings) bind(c, name="weft_replay_settings_default")
      import; type(replay_settings), intent(inout) :: settings; integer(c_int) :: c_replay_settings_default
    end function
    function c_replay(graph, settings, summary, json) bind(c, name="weft_replay")
      import; character(c_char), intent(in) :: graph(*); type(replay_settings), intent(in) :: settings
      type(c_ptr), intent(inout) :: summary, json; integer(c_int) :: c_replay
    end function
    function c_graph_filter_default(filter) bind(c, name="weft_graph_filter_default")
      import; type(graph_filter), intent(inout) :: filter; integer(c_int) :: c_graph_filter_default
    end function
    function c_graph_text(path, form, filter, text) bind(c, name="weft_graph_text")
      import; character(c_char), intent(in) :: path(*), form(*); type(graph_filter), intent(in) :: filter
      type(c_ptr), intent(inout) :: text; integer(c_int) :: c_graph_text
    end function
    function c_report_page(profile, page) bind(c, name="weft_report_page")
      import; character(c_char), intent(in) :: profile(*), page(*); integer(c_int) :: c_report_page
    end function
    function c_compare_reports(a, b, page, text) bind(c, name="weft_compare_reports")
      import; character(c_char), intent(in) :: a(*), b(*); type(c_ptr), value :: page
      type(c_ptr), intent(inout) :: text; integer(c_int) :: c_compare_reports
    end function
    function c_draw_histograms(path, mesh, metric) bind(c, name="weft_draw_histograms")
      import; character(c_char), intent(in) :: path(*); type(c_ptr), value :: mesh, metric
      integer(c_int) :: c_draw_histograms
    end function
    function c_picture_settings_default(settings) bind(c, name="weft_picture_settings_default")
      import; type(picture_settings), intent(inout) :: settings; integer(c_int) :: c_picture_settings_default
    end function
    function c_draw(path, mesh, metric, field, num_values, settings) bind(c, name="weft_draw")
      import; character(c_char), intent(in) :: path(*); type(c_ptr), value :: mesh, metric, field
      integer(c_int64_t), value :: num_values; type(picture_settings), intent(in) :: settings; integer(c_int) :: c_draw
    end function
    function c_fill_settings_default(settings) bind(c, name="weft_fill_settings_default")
      import; type(weft_fill_settings), intent(inout) :: settings; integer(c_int) :: c_fill_settings_default
    end function
    function c_fill_to_background(surface, background, sizes, settings, options, mesh, metric) &
      bind(c, name="weft_fill_to_background")
      import; type(c_ptr), value :: surface, background, sizes, settings, options
      type(c_ptr), intent(inout) :: mesh, metric; integer(c_int) :: c_fill_to_background
    end function
    !> Triangles on the CAD model that the option geometry names; angle: degrees that the normal turns along an edge,
    !> 0: 20.
    function weft_tessellate(options, angle, surface) bind(c)
      import; type(c_ptr), value :: options; real(c_double), value :: angle; type(c_ptr), intent(inout) :: surface
      integer(c_int) :: weft_tessellate
    end function
    !> The triangles of simple bodies, with edges of length `size`.
    function weft_ball_surface(radius, center, size, surface) bind(c)
      import; real(c_double), value :: radius, size; real(c_double), intent(in) :: center(3)
      type(c_ptr), intent(inout) :: surface; integer(c_int) :: weft_ball_surface
    end function
    function weft_cylinder_surface(radius, height, base, size, surface) bind(c)
      import; real(c_double), value :: radius, height, size; real(c_double), intent(in) :: base(3)
      type(c_ptr), intent(inout) :: surface; integer(c_int) :: weft_cylinder_surface
    end function
    function weft_delta_wing_surface(size, surface) bind(c)
      import; real(c_double), value :: size; type(c_ptr), intent(inout) :: surface
      integer(c_int) :: weft_delta_wing_surface
    end function
    function c_fill(surface, settings, options, mesh, metric) bind(c, name="weft_fill")
      import; type(c_ptr), value :: surface, settings, options; type(c_ptr), intent(inout) :: mesh, metric
      integer(c_int) :: c_fill
    end function
  end interface

contains

  !> What the last call of this thread that failed had to say.
  function weft_error() result(text)
    character(:), allocatable :: text
    text = text_of(c_last_error())
  end function weft_error

  function text_of(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(:), allocatable :: text
    character(c_char), pointer :: letters(:)
    integer :: length, i
    interface
      pure function strlen(text) bind(c)
        import; type(c_ptr), value :: text; integer(c_size_t) :: strlen
      end function
    end interface
    length = 0
    if (c_associated(pointer)) length = int(strlen(pointer))
    allocate (character(length) :: text)
    if (length == 0) return
    call c_f_pointer(pointer, letters, [length])
    do i = 1, length
      text(i:i) = letters(i)
    end do
  end function text_of

  !> The letters of a text of weft's, which is freed.
  function text_taken(handle) result(text)
    type(c_ptr), intent(in) :: handle
    character(:), allocatable :: text
    type(c_ptr) :: letters
    integer(c_int) :: status
    letters = c_null_ptr
    status = c_text_get(handle, letters)
    text = text_of(letters)
    status = weft_free(handle)
  end function text_taken

  !> Where a text ends with a null, and lies as long as `kept` does; c_null_ptr for one that is not there.
  function address_of(text, kept) result(address)
    character(*), intent(in), optional :: text
    character(len=:, kind=c_char), allocatable, target, intent(inout) :: kept
    type(c_ptr) :: address
    address = c_null_ptr
    if (.not. present(text)) return
    kept = trim(text)//c_null_char
    address = c_loc(kept(1:1))
  end function address_of

  !> weft_misuse, of which weft_error() says that the array has `found` of what `wanted` says.
  function refused(array, found, wanted) result(status)
    character(*), intent(in) :: array, wanted
    integer(c_int64_t), intent(in) :: found
    integer(c_int) :: status
    status = c_refuse(array//": has "//text_of_number(found)//wanted//c_null_char)
  end function refused

  pure function text_of_number(number) result(text)
    integer(c_int64_t), intent(in) :: number
    character(:), allocatable :: text
    character(20) :: digits
    write (digits, "(i0)") number
    text = trim(digits)
  end function text_of_number

  !> Of points(3, n) and tets(4, m), which count points from 1.
  function weft_mesh_create(points, tets, mesh) result(status)
    real(c_double), intent(in), contiguous :: points(:, :)
    integer(c_int64_t), intent(in) :: tets(:, :)
    type(c_ptr), intent(inout) :: mesh
    integer(c_int) :: status
    integer(c_int64_t), allocatable :: from_0(:, :)
    if (size(points, 1) /= 3) then
      status = refused("points", size(points, 1, c_int64_t), " rows, not (3, n)")
      return
    else if (size(tets, 1) /= 4) then
      status = refused("tets", size(tets, 1, c_int64_t), " rows, not (4, m)")
      return
    end if
    allocate (from_0, source=tets)
    from_0 = from_0 - 1
    status = c_mesh_create(size(points, 2, c_int64_t), points, size(tets, 2, c_int64_t), from_0, mesh)
  end function weft_mesh_create

  pure function is_of_refs(which)
    integer(c_int), intent(in) :: which
    logical :: is_of_refs
    is_of_refs = any(which == [weft_tet_refs, weft_triangle_refs, weft_edge_refs, weft_point_refs])
  end function is_of_refs

  pure function width_of(which) result(width)
    integer(c_int), intent(in) :: which
    integer(c_int64_t) :: width
    width = 1
    if (which == weft_tets) width = 4
    if (which == weft_triangles) width = 3
    if (which == weft_edges) width = 2
  end function width_of

  !> Replaces an array, given as a list: reshape(triangles, [size(triangles)]). Indices count from 1.
  function weft_mesh_set(mesh, which, values) result(status)
    type(c_ptr), intent(in) :: mesh
    integer(c_int), intent(in) :: which
    integer(c_int64_t), intent(in) :: values(:)
    integer(c_int) :: status
    integer(c_int64_t), allocatable :: from_0(:)
    if (mod(size(values, kind=c_int64_t), width_of(which)) /= 0) then
      status = refused("values", size(values, kind=c_int64_t), " numbers, not "//text_of_number(width_of(which))// &
                       " for each entity")
      return
    end if
    allocate (from_0, source=values)
    if (.not. is_of_refs(which)) from_0 = from_0 - 1
    status = c_mesh_set(mesh, which, size(values, kind=c_int64_t) / width_of(which), from_0)
  end function weft_mesh_set

  !> An array as a list; indices count from 1.
  function weft_mesh_get(mesh, which, values) result(status)
    type(c_ptr), intent(in) :: mesh
    integer(c_int), intent(in) :: which
    integer(c_int64_t), allocatable, intent(inout) :: values(:)
    integer(c_int) :: status
    integer(c_int64_t) :: count
    count = 0
    status = weft_mesh_count(mesh, which, count)
    if (status /= weft_ok) return
    if (allocated(values)) deallocate (values)
    allocate (values(width_of(which) * count))
    status = c_mesh_get(mesh, which, size(values, kind=c_int64_t), values)
    if (.not. is_of_refs(which)) values = values + 1
  end function weft_mesh_get

  !> weft's own coordinates (3, n), not copied: valid until the mesh is changed or freed.
  function weft_mesh_points(mesh, points) result(status)
    type(c_ptr), intent(in) :: mesh
    real(c_double), pointer, intent(out) :: points(:, :)
    integer(c_int) :: status
    type(c_ptr) :: first
    integer(c_int64_t) :: count
    nullify (points)
    count = 0
    first = c_null_ptr
    status = weft_mesh_num_points(mesh, count)
    if (status == weft_ok) status = c_mesh_points(mesh, first)
    if (status == weft_ok) call c_f_pointer(first, points, [3_c_int64_t, count])
  end function weft_mesh_points

  function weft_mesh_read(path, mesh) result(status)
    character(*), intent(in) :: path
    type(c_ptr), intent(inout) :: mesh
    integer(c_int) :: status
    status = c_mesh_read(trim(path)//c_null_char, mesh)
  end function weft_mesh_read

  function weft_mesh_write(mesh, path) result(status)
    type(c_ptr), intent(in) :: mesh
    character(*), intent(in) :: path
    integer(c_int) :: status
    status = c_mesh_write(mesh, trim(path)//c_null_char)
  end function weft_mesh_write

  function weft_metric_from_sizes(sizes, metric) result(status)
    real(c_double), intent(in), contiguous :: sizes(:)
    type(c_ptr), intent(inout) :: metric
    integer(c_int) :: status
    status = c_metric_from_sizes(size(sizes, kind=c_int64_t), sizes, metric)
  end function weft_metric_from_sizes

  !> Of tensors(6, n).
  function weft_metric_from_tensors(tensors, order, metric) result(status)
    real(c_double), intent(in), contiguous :: tensors(:, :)
    integer(c_int), intent(in) :: order
    type(c_ptr), intent(inout) :: metric
    integer(c_int) :: status
    if (size(tensors, 1) == 6) then
      status = c_metric_from_tensors(size(tensors, 2, c_int64_t), tensors, order, metric)
    else
      status = refused("tensors", size(tensors, 1, c_int64_t), " rows, not (6, n)")
    end if
  end function weft_metric_from_tensors

  function weft_metric_read(path, mesh, metric) result(status)
    character(*), intent(in) :: path
    type(c_ptr), intent(in) :: mesh
    type(c_ptr), intent(inout) :: metric
    integer(c_int) :: status
    status = c_metric_read(trim(path)//c_null_char, mesh, metric)
  end function weft_metric_read

  function weft_metric_write(metric, path) result(status)
    type(c_ptr), intent(in) :: metric
    character(*), intent(in) :: path
    integer(c_int) :: status
    status = c_metric_write(metric, trim(path)//c_null_char)
  end function weft_metric_write

  !> tensors(6, n).
  function weft_metric_get(metric, order, tensors) result(status)
    type(c_ptr), intent(in) :: metric
    integer(c_int), intent(in) :: order
    real(c_double), intent(inout), contiguous :: tensors(:, :)
    integer(c_int) :: status
    status = c_metric_get(metric, order, size(tensors, kind=c_int64_t), tensors)
  end function weft_metric_get

  function weft_fields_create(num_points, fields) result(status)
    integer(c_int64_t), intent(in) :: num_points
    type(c_ptr), intent(inout) :: fields
    integer(c_int) :: status
    status = c_fields_create(num_points, fields)
  end function weft_fields_create

  !> values(components, n), with 1, 3 or 6 (weft_order_sol) components.
  function weft_fields_add(fields, name, values) result(status)
    type(c_ptr), intent(in) :: fields
    character(*), intent(in) :: name
    real(c_double), intent(in), contiguous :: values(:, :)
    integer(c_int) :: status
    integer(c_int64_t) :: num_fields, num_points
    status = c_fields_count(fields, num_fields, num_points)
    if (status /= weft_ok) return
    if (size(values, 2, c_int64_t) == num_points) then
      status = c_fields_add(fields, trim(name)//c_null_char, size(values, 1, c_int), values)
    else
      status = refused(trim(name), size(values, 2, c_int64_t), " columns, not one for each of the "// &
                       text_of_number(num_points)//" points")
    end if
  end function weft_fields_add

  !> weft's own values (components, n) of a field, from 1: valid until the fields are freed or changed, as by adding one
  !> or by a repair.
  function weft_fields_get(fields, index, name, values) result(status)
    type(c_ptr), intent(in) :: fields
    integer, intent(in) :: index
    character(:), allocatable, intent(inout) :: name
    real(c_double), pointer, intent(out) :: values(:, :)
    integer(c_int) :: status, components
    type(c_ptr) :: letters, first
    integer(c_int64_t) :: num_fields, num_points
    nullify (values)
    letters = c_null_ptr
    first = c_null_ptr
    status = c_fields_count(fields, num_fields, num_points)
    if (status == weft_ok) &
      status = c_fields_get(fields, int(index - 1, c_int64_t), letters, components, first)
    if (status /= weft_ok) return
    name = text_of(letters)
    call c_f_pointer(first, values, [int(components, c_int64_t), num_points])
  end function weft_fields_get

  !> All defaults; weft_options_set changes them.
  function weft_options_create(options) result(status)
    type(c_ptr), intent(inout) :: options
    integer(c_int) :: status
    status = c_options_create(c_null_ptr, options)
  end function weft_options_create

  !> By the command's name without dashes, such as "hgrad-space".
  function options_set_text(options, name, value) result(status)
    type(c_ptr), intent(in) :: options
    character(*), intent(in) :: name, value
    integer(c_int) :: status
    status = c_options_set(options, trim(name)//c_null_char, trim(value)//c_null_char)
  end function options_set_text

  function options_set_real(options, name, value) result(status)
    type(c_ptr), intent(in) :: options
    character(*), intent(in) :: name
    real(c_double), intent(in) :: value
    integer(c_int) :: status
    status = c_options_set_number(options, trim(name)//c_null_char, value)
  end function options_set_real

  function options_set_integer(options, name, value) result(status)
    type(c_ptr), intent(in) :: options
    character(*), intent(in) :: name
    integer, intent(in) :: value
    integer(c_int) :: status
    status = c_options_set_number(options, trim(name)//c_null_char, real(value, c_double))
  end function options_set_integer

  !> `call_back` is told how far runs are, on rank 0; `user` is passed on to it.
  function weft_set_progress(options, call_back, user) result(status)
    type(c_ptr), intent(in) :: options
    procedure(weft_progress_function) :: call_back
    type(c_ptr), intent(in) :: user
    integer(c_int) :: status
    status = c_options_set_progress(options, c_funloc(call_back), user)
  end function weft_set_progress

  !> A rank's part: its mesh, the global ids of its points, and (or c_null_ptr) fields at its points. The global ids of
  !> its tets fix their order.
  function weft_part_create(mesh, point_ids, fields, part, tet_ids) result(status)
    type(c_ptr), intent(in) :: mesh, fields
    integer(c_int64_t), intent(in), contiguous :: point_ids(:)
    type(c_ptr), intent(inout) :: part
    integer(c_int64_t), intent(in), contiguous, optional, target :: tet_ids(:)
    integer(c_int) :: status
    integer(c_int64_t) :: points, tets
    type(c_ptr) :: first_tet
    status = weft_mesh_num_points(mesh, points)
    if (status == weft_ok) status = weft_mesh_count(mesh, weft_tets, tets)
    if (status /= weft_ok) return
    first_tet = c_null_ptr
    if (size(point_ids, kind=c_int64_t) /= points) then
      status = refused("point_ids", size(point_ids, kind=c_int64_t), " ids, not one for each of the "// &
                       text_of_number(points)//" points")
      return
    end if
    if (present(tet_ids)) then
      if (size(tet_ids, kind=c_int64_t) /= tets) then
        status = refused("tet_ids", size(tet_ids, kind=c_int64_t), " ids, not one for each of the "// &
                         text_of_number(tets)//" tets")
        return
      end if
      if (tets > 0) first_tet = c_loc(tet_ids)
    end if
    status = c_part_create(mesh, point_ids, first_tet, fields, part)
  end function weft_part_create

  !> Tets behind the first `num_own_tets` are ghosts; owners: the rank that has each of them, not copied.
  function weft_part_ghosts(part, num_own_tets, owners) result(status)
    type(c_ptr), intent(in) :: part
    integer(c_int64_t), intent(inout) :: num_own_tets
    integer(c_int), pointer, intent(out) :: owners(:)
    integer(c_int) :: status, freed
    type(c_ptr) :: mesh, first
    integer(c_int64_t) :: tets
    nullify (owners)
    mesh = c_null_ptr
    first = c_null_ptr
    tets = 0
    status = weft_part_mesh(part, mesh)
    if (status == weft_ok) status = weft_mesh_count(mesh, weft_tets, tets)
    freed = weft_free(mesh)
    if (status == weft_ok) status = c_part_ghosts(part, num_own_tets, first)
    if (status == weft_ok .and. c_associated(first)) call c_f_pointer(first, owners, [tets - num_own_tets])
  end function weft_part_ghosts

  !> From file to file, as `weft adapt` does. background: the mesh that the metric belongs to. fields: files of fields
  !> that are carried along. report: a folder, without its page where page is false. graph, trace: files, of runs in
  !> subdomains. simulate_ranks: so many ranks that this thread simulates, whose threads share simulate_cores cores.
  function weft_adapt_files(input, output, options, result, background, fields, report, page, case_name, graph, trace, &
                            simulate_ranks, simulate_network, simulate_slowdown, simulate_cores) result(status)
    character(*), intent(in) :: input, output
    type(c_ptr), intent(in) :: options
    type(c_ptr), intent(inout) :: result
    character(*), intent(in), optional :: background, fields(:), report, case_name, graph, trace, simulate_network
    logical, intent(in), optional :: page
    integer, intent(in), optional :: simulate_ranks
    real(c_double), intent(in), optional :: simulate_slowdown
    integer, intent(in), optional :: simulate_cores
    integer(c_int) :: status
    type(file_settings) :: settings
    character(len=:, kind=c_char), allocatable, target :: background_0, report_0, case_0, graph_0, trace_0, network_0
    character(kind=c_char), allocatable, target :: letters(:, :)
    type(c_ptr), allocatable, target :: places(:)
    integer :: i, j
    settings%size = c_sizeof(settings)
    status = c_file_settings_default(settings)
    if (status /= weft_ok) return
    settings%background = address_of(background, background_0)
    settings%report = address_of(report, report_0)
    settings%case_name = address_of(case_name, case_0)
    settings%graph = address_of(graph, graph_0)
    settings%trace = address_of(trace, trace_0)
    if (present(page)) settings%page = merge(1, 0, page)
    if (present(simulate_ranks)) settings%simulate_ranks = int(simulate_ranks, c_int32_t)
    if (present(simulate_network)) settings%simulate_network = address_of(simulate_network, network_0)
    if (present(simulate_slowdown)) settings%simulate_slowdown = simulate_slowdown
    if (present(simulate_cores)) settings%simulate_cores = int(simulate_cores, c_int32_t)
    if (present(fields)) then
      allocate (letters(len(fields) + 1, size(fields)), places(size(fields)))
      letters = c_null_char
      do i = 1, size(fields)
        do j = 1, len_trim(fields(i))
          letters(j, i) = fields(i) (j:j)
        end do
        places(i) = c_loc(letters(1, i))
      end do
      settings%num_fields = size(fields, kind=c_int64_t)
      if (size(fields) > 0) settings%fields = c_loc(places)
    end if
    status = c_adapt_files_with(trim(input)//c_null_char, trim(output)//c_null_char, settings, options, result)
  end function weft_adapt_files

  !> From file to file, as `weft convert` does. solution: a file of fields. encoding: "binary", "ascii", "big-endian".
  !> msh_version: 4 or 2. dropped: what had no place, a line each.
  function weft_convert(input, output, solution, encoding, msh_version, compress, pieces, dropped) result(status)
    character(*), intent(in) :: input, output
    character(*), intent(in), optional :: solution, encoding
    integer, intent(in), optional :: msh_version, pieces
    logical, intent(in), optional :: compress
    character(:), allocatable, intent(inout), optional :: dropped
    integer(c_int) :: status
    type(write_settings) :: settings
    character(len=:, kind=c_char), allocatable, target :: encoding_0
    character(:), allocatable :: text, fields
    type(c_ptr) :: told
    settings%size = c_sizeof(settings)
    status = c_write_settings_default(settings)
    if (status /= weft_ok) return
    if (present(encoding)) settings%encoding = address_of(encoding, encoding_0)
    if (present(msh_version)) settings%msh_version = int(msh_version, c_int32_t)
    if (present(compress)) settings%compress = merge(1, 0, compress)
    if (present(pieces)) settings%pieces = int(pieces, c_int32_t)
    fields = ""
    if (present(solution)) fields = trim(solution)
    told = c_null_ptr
    status = c_convert(trim(input)//c_null_char, trim(output)//c_null_char, fields//c_null_char, settings, told)
    if (status /= weft_ok) return
    text = text_taken(told)
    if (present(dropped)) dropped = text
  end function weft_convert

  !> A box of cells(3), 6 tets each: the unit cube, or from `min` to `max`.
  function weft_mesh_box(cells, mesh, min, max) result(status)
    integer(c_int64_t), intent(in) :: cells(3)
    type(c_ptr), intent(inout) :: mesh
    real(c_double), intent(in), optional :: min(3), max(3)
    integer(c_int) :: status
    real(c_double) :: corners(3, 2)
    corners(:, 1) = 0
    corners(:, 2) = 1
    if (present(min)) corners(:, 1) = min
    if (present(max)) corners(:, 2) = max
    status = c_mesh_box_between(cells, corners(:, 1), corners(:, 2), mesh)
  end function weft_mesh_box

  function weft_fields_read(path, fields) result(status)
    character(*), intent(in) :: path
    type(c_ptr), intent(inout) :: fields
    integer(c_int) :: status
    status = c_fields_read(trim(path)//c_null_char, fields)
  end function weft_fields_read

  function weft_fields_write(fields, path) result(status)
    type(c_ptr), intent(in) :: fields
    character(*), intent(in) :: path
    integer(c_int) :: status
    status = c_fields_write(fields, trim(path)//c_null_char)
  end function weft_fields_write

  !> What became of a component of fields that weft_interpolate has made, from 1; the components of all fields count.
  function weft_fields_account(fields, index, account, name) result(status)
    type(c_ptr), intent(in) :: fields
    integer, intent(in) :: index
    type(weft_component_account), intent(inout) :: account
    character(:), allocatable, intent(inout), optional :: name
    integer(c_int) :: status
    account%size = c_sizeof(account)
    status = c_fields_account(fields, int(index - 1, c_int64_t), account)
    if (status == weft_ok .and. present(name)) name = text_of(account%name)
  end function weft_fields_account

  function weft_measure(mesh, metric, measures) result(status)
    type(c_ptr), intent(in) :: mesh, metric
    type(weft_measures), intent(inout) :: measures
    integer(c_int) :: status
    measures%size = c_sizeof(measures)
    status = c_measure(mesh, metric, measures)
  end function weft_measure

  !> What `weft stat --json` tells; metric and options (geometry, geometry-scale) may be c_null_ptr.
  function weft_stat(mesh, metric, options, json) result(status)
    type(c_ptr), intent(in) :: mesh, metric, options
    character(:), allocatable, intent(inout) :: json
    integer(c_int) :: status
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_stat(mesh, metric, options, told)
    if (status == weft_ok) json = text_taken(told)
  end function weft_stat

  !> Mends what can be mended of a mesh that weft_adapt() would refuse; fields (c_null_ptr: none) at its vertices
  !> follow. mends: what was done.
  function weft_mesh_repair(mesh, fields, mends) result(status)
    type(c_ptr), intent(in) :: mesh, fields
    character(:), allocatable, intent(inout) :: mends
    integer(c_int) :: status
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_mesh_repair(mesh, fields, told)
    if (status == weft_ok) mends = text_taken(told)
  end function weft_mesh_repair

  !> The same for a metric in fields (tensors or sizes) at the vertices of a mesh.
  function weft_fields_repair_metric(fields, mesh, mends) result(status)
    type(c_ptr), intent(in) :: fields, mesh
    character(:), allocatable, intent(inout) :: mends
    integer(c_int) :: status
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_fields_repair_metric(fields, mesh, told)
    if (status == weft_ok) mends = text_taken(told)
  end function weft_fields_repair_metric

  !> The same for triangles that are to bound a volume, before weft_fill().
  function weft_surface_repair(surface, mends) result(status)
    type(c_ptr), intent(in) :: surface
    character(:), allocatable, intent(inout) :: mends
    integer(c_int) :: status
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_surface_repair(surface, told)
    if (status == weft_ok) mends = text_taken(told)
  end function weft_surface_repair

  !> Histograms of quality and length: .png, .svg or .pdf.
  function weft_draw_histograms(path, mesh, metric) result(status)
    character(*), intent(in) :: path
    type(c_ptr), intent(in) :: mesh, metric
    integer(c_int) :: status
    status = c_draw_histograms(trim(path)//c_null_char, mesh, metric)
  end function weft_draw_histograms

  !> Draws a mesh into a .png, .svg or .pdf, as `weft view` does. field: a value for each point, which colours it.
  !> metric: c_null_ptr unless qualities or lengths do. only: references of boundary triangles. The rest are the options
  !> of the command, view_from its --from.
  function weft_draw(path, mesh, metric, field, color_by, pixels, view_from, up, clip, focus, range, title, only, zoom, &
                     line_width, dark, flip, slice, edges, legend, axes) result(status)
    character(*), intent(in) :: path
    type(c_ptr), intent(in) :: mesh, metric
    real(c_double), intent(in), contiguous, target, optional :: field(:)
    character(*), intent(in), optional :: color_by, pixels, view_from, up, clip, focus, range, title
    integer(c_int32_t), intent(in), contiguous, target, optional :: only(:)
    real(c_double), intent(in), optional :: zoom, line_width
    logical, intent(in), optional :: dark, flip, slice, edges, legend, axes
    integer(c_int) :: status
    type(picture_settings) :: settings
    character(len=:, kind=c_char), allocatable, target :: color_by_0, pixels_0, from_0, up_0, clip_0, focus_0, range_0, title_0
    type(c_ptr) :: values
    integer(c_int64_t) :: num_values
    settings%size = c_sizeof(settings)
    status = c_picture_settings_default(settings)
    if (status /= weft_ok) return
    if (present(color_by)) settings%color_by = address_of(color_by, color_by_0)
    if (present(pixels)) settings%pixels = address_of(pixels, pixels_0)
    if (present(view_from)) settings%from = address_of(view_from, from_0)
    settings%up = address_of(up, up_0)
    settings%clip = address_of(clip, clip_0)
    settings%focus = address_of(focus, focus_0)
    settings%range = address_of(range, range_0)
    settings%title = address_of(title, title_0)
    if (present(only)) then
      settings%num_only = size(only, kind=c_int64_t)
      if (size(only) > 0) settings%only = c_loc(only)
    end if
    if (present(zoom)) settings%zoom = zoom
    if (present(line_width)) settings%line_width = line_width
    if (present(dark)) settings%dark = merge(1, 0, dark)
    if (present(flip)) settings%flip = merge(1, 0, flip)
    if (present(slice)) settings%slice = merge(1, 0, slice)
    if (present(edges)) settings%edges = merge(1, 0, edges)
    if (present(legend)) settings%legend = merge(1, 0, legend)
    if (present(axes)) settings%axes = merge(1, 0, axes)
    values = c_null_ptr
    num_values = 0
    if (present(field)) then
      num_values = size(field, kind=c_int64_t)
      if (num_values == 0) then
        status = refused("field", num_values, " values, not one for each point")
        return
      end if
      values = c_loc(field)
    end if
    status = c_draw(trim(path)//c_null_char, mesh, metric, values, num_values, settings)
  end function weft_draw

  !> What a recorded run (graph.json or profile.json) would take on another machine, as `weft replay` says; the options
  !> are those of the command. json and summary: the account for programs and for people.
  function weft_replay(graph, json, summary, ranks, threads, network, balancer, slowdown, processor_times, copies, split, &
                       grow, subdomain_bytes, report, account, trace) result(status)
    character(*), intent(in) :: graph
    character(:), allocatable, intent(inout) :: json
    character(:), allocatable, intent(inout), optional :: summary
    integer, intent(in), optional :: ranks, threads, copies, split
    integer(c_int64_t), intent(in), optional :: subdomain_bytes
    character(*), intent(in), optional :: network, balancer, report, account, trace
    real(c_double), intent(in), optional :: slowdown, grow
    logical, intent(in), optional :: processor_times
    integer(c_int) :: status
    type(replay_settings) :: settings
    character(len=:, kind=c_char), allocatable, target :: network_0, balancer_0, report_0, account_0, trace_0
    character(:), allocatable :: text
    type(c_ptr) :: told, for_programs
    settings%size = c_sizeof(settings)
    status = c_replay_settings_default(settings)
    if (status /= weft_ok) return
    if (present(ranks)) settings%ranks = int(ranks, c_int32_t)
    if (present(threads)) settings%threads = int(threads, c_int32_t)
    if (present(network)) settings%network = address_of(network, network_0)
    if (present(balancer)) settings%balancer = address_of(balancer, balancer_0)
    if (present(slowdown)) settings%slowdown = slowdown
    if (present(processor_times)) settings%processor_times = merge(1, 0, processor_times)
    if (present(copies)) settings%copies = int(copies, c_int32_t)
    if (present(split)) settings%split = int(split, c_int32_t)
    if (present(grow)) settings%grow = grow
    if (present(subdomain_bytes)) settings%subdomain_bytes = subdomain_bytes
    settings%report = address_of(report, report_0)
    settings%account = address_of(account, account_0)
    settings%trace = address_of(trace, trace_0)
    told = c_null_ptr
    for_programs = c_null_ptr
    status = c_replay(trim(graph)//c_null_char, settings, told, for_programs)
    if (status /= weft_ok) return
    json = text_taken(for_programs)
    text = text_taken(told)
    if (present(summary)) summary = text
  end function weft_replay

  !> The task graph of a run (graph.json, profile.json) as "dot", "graphml", "json" or "svg". round and subdomain: only
  !> runs of this one, from 0. collapse: "none", "rounds", "subdomains".
  function weft_graph_text(path, form, text, round, subdomain, collapse, critical_path, plan) result(status)
    character(*), intent(in) :: path, form
    character(:), allocatable, intent(inout) :: text
    integer, intent(in), optional :: round, subdomain
    character(*), intent(in), optional :: collapse
    logical, intent(in), optional :: critical_path, plan
    integer(c_int) :: status
    type(graph_filter) :: filter
    character(len=:, kind=c_char), allocatable, target :: collapse_0
    type(c_ptr) :: told
    filter%size = c_sizeof(filter)
    status = c_graph_filter_default(filter)
    if (status /= weft_ok) return
    if (present(round)) filter%round = round
    if (present(subdomain)) filter%subdomain = subdomain
    if (present(collapse)) filter%collapse = address_of(collapse, collapse_0)
    if (present(critical_path)) filter%critical_path = merge(1, 0, critical_path)
    if (present(plan)) filter%plan = merge(1, 0, plan)
    told = c_null_ptr
    status = c_graph_text(trim(path)//c_null_char, trim(form)//c_null_char, filter, told)
    if (status == weft_ok) text = text_taken(told)
  end function weft_graph_text

  !> Writes the page of a run's profile.json.
  function weft_report_page(profile, page) result(status)
    character(*), intent(in) :: profile, page
    integer(c_int) :: status
    status = c_report_page(trim(profile)//c_null_char, trim(page)//c_null_char)
  end function weft_report_page

  !> What got slower from run a to run b (profile.json or report.json), and how the meshes differ; page: as a page too.
  function weft_compare_reports(a, b, text, page) result(status)
    character(*), intent(in) :: a, b
    character(:), allocatable, intent(inout) :: text
    character(*), intent(in), optional :: page
    integer(c_int) :: status
    character(len=:, kind=c_char), allocatable, target :: page_0
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_compare_reports(trim(a)//c_null_char, trim(b)//c_null_char, address_of(page, page_0), told)
    if (status == weft_ok) text = text_taken(told)
  end function weft_compare_reports

  !> Of a result's part, not copied: ids from 0 without gaps, and the rank that owns each point.
  function weft_part_points(part, ids, owners) result(status)
    type(c_ptr), intent(in) :: part
    integer(c_int64_t), pointer, intent(out) :: ids(:)
    integer(c_int), pointer, intent(out) :: owners(:)
    integer(c_int) :: status, freed
    type(c_ptr) :: mesh, first_id, first_owner
    integer(c_int64_t) :: points
    nullify (ids, owners)
    mesh = c_null_ptr
    first_id = c_null_ptr
    first_owner = c_null_ptr
    points = 0
    status = weft_part_mesh(part, mesh)
    if (status == weft_ok) status = weft_mesh_num_points(mesh, points)
    freed = weft_free(mesh)
    if (status == weft_ok) status = c_part_points(part, first_id, first_owner)
    if (status /= weft_ok) return
    if (c_associated(first_id)) call c_f_pointer(first_id, ids, [points])
    if (c_associated(first_owner)) call c_f_pointer(first_owner, owners, [points])
  end function weft_part_points

  !> Mesh, metric beside it, and fields.
  function weft_result_write(result, path) result(status)
    type(c_ptr), intent(in) :: result
    character(*), intent(in) :: path
    integer(c_int) :: status
    status = c_result_write(result, trim(path)//c_null_char)
  end function weft_result_write

  function weft_result_measures(result, measures) result(status)
    type(c_ptr), intent(in) :: result
    type(weft_measures), intent(inout) :: measures
    integer(c_int) :: status
    measures%size = c_sizeof(measures)
    status = c_result_measures(result, measures)
  end function weft_result_measures

  !> What the command prints.
  function weft_result_summary(result, text) result(status)
    type(c_ptr), intent(in) :: result
    character(:), allocatable, intent(inout) :: text
    integer(c_int) :: status
    type(c_ptr) :: letters
    letters = c_null_ptr
    status = c_result_summary(result, letters)
    text = text_of(letters)
  end function weft_result_summary

  !> JSON of schema weft-report-1.
  function weft_result_json(result, text) result(status)
    type(c_ptr), intent(in) :: result
    character(:), allocatable, intent(inout) :: text
    integer(c_int) :: status
    type(c_ptr) :: letters
    letters = c_null_ptr
    status = c_result_json(result, letters)
    text = text_of(letters)
  end function weft_result_json

  !> What else there is to tell of a run, by weft_warnings, weft_mends, weft_missed or weft_ended_by: a line each.
  function weft_result_told(result, what, text) result(status)
    type(c_ptr), intent(in) :: result
    integer(c_int), intent(in) :: what
    character(:), allocatable, intent(inout) :: text
    integer(c_int) :: status
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_result_told(result, what, told)
    if (status == weft_ok) text = text_taken(told)
  end function weft_result_told

  !> Of a result of weft_fill_to_result.
  function weft_result_fill(result, account) result(status)
    type(c_ptr), intent(in) :: result
    type(weft_fill_account), intent(inout) :: account
    integer(c_int) :: status
    account%size = c_sizeof(account)
    status = c_result_fill(result, account)
  end function weft_result_fill

  !> The metric that options ask for, with what there is to warn of, a line each; `source` may be c_null_ptr.
  function weft_metric_make_with(mesh, source, options, metric, warnings) result(status)
    type(c_ptr), intent(in) :: mesh, source, options
    type(c_ptr), intent(inout) :: metric
    character(:), allocatable, intent(inout) :: warnings
    integer(c_int) :: status
    type(c_ptr) :: told
    told = c_null_ptr
    status = c_metric_make_with(mesh, source, options, metric, told)
    if (status == weft_ok) warnings = text_taken(told)
  end function weft_metric_make_with

  !> Of files: report.json, and what could not be written beside the mesh, and why; empty where there is none.
  function weft_result_report(result, report, error) result(status)
    type(c_ptr), intent(in) :: result
    character(:), allocatable, intent(inout) :: report, error
    integer(c_int) :: status
    type(c_ptr) :: path, reason
    path = c_null_ptr
    reason = c_null_ptr
    status = c_result_report(result, path, reason)
    report = text_of(path)
    error = text_of(reason)
  end function weft_result_report

  function weft_fill_settings_default(settings) result(status)
    type(weft_fill_settings), intent(inout) :: settings
    integer(c_int) :: status
    settings%size = c_sizeof(settings)
    status = c_fill_settings_default(settings)
  end function weft_fill_settings_default

  !> Fills the volumes that the triangles of a mesh bound; options may be c_null_ptr.
  function weft_fill(surface, options, mesh, metric, settings) result(status)
    type(c_ptr), intent(in) :: surface, options
    type(c_ptr), intent(inout) :: mesh, metric
    type(weft_fill_settings), intent(in), optional, target :: settings
    integer(c_int) :: status
    type(c_ptr) :: place
    place = c_null_ptr
    if (present(settings)) place = c_loc(settings)
    status = c_fill(surface, place, options, mesh, metric)
  end function weft_fill

  !> The same with the sizes at the vertices of `background` instead of the surface's.
  function weft_fill_to_background(surface, background, sizes, options, mesh, metric, settings) result(status)
    type(c_ptr), intent(in) :: surface, background, sizes, options
    type(c_ptr), intent(inout) :: mesh, metric
    type(weft_fill_settings), intent(in), optional, target :: settings
    integer(c_int) :: status
    type(c_ptr) :: place
    place = c_null_ptr
    if (present(settings)) place = c_loc(settings)
    status = c_fill_to_background(surface, background, sizes, place, options, mesh, metric)
  end function weft_fill_to_background

  !> The same as both, with what there is to say of it: a result; background and sizes may be c_null_ptr.
  function weft_fill_to_result(surface, background, sizes, options, result, settings) result(status)
    type(c_ptr), intent(in) :: surface, background, sizes, options
    type(c_ptr), intent(inout) :: result
    type(weft_fill_settings), intent(in), optional, target :: settings
    integer(c_int) :: status
    type(c_ptr) :: place
    place = c_null_ptr
    if (present(settings)) place = c_loc(settings)
    status = c_fill_to_result(surface, background, sizes, place, options, result)
  end function weft_fill_to_result
end module weft
