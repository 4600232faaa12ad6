!> Adapts a mesh to a metric, both from files: adapt_file IN.meshb METRIC.solb OUT.meshb
program adapt_file
  use, intrinsic :: iso_c_binding
  use weft
  implicit none
  type(c_ptr) :: mesh = c_null_ptr, metric = c_null_ptr, options = c_null_ptr, result = c_null_ptr
  character(1000) :: input, sizes, output
  character(:), allocatable :: summary
  integer(c_int) :: freed

  call get_command_argument(1, input)
  call get_command_argument(2, sizes)
  call get_command_argument(3, output)
  call check(weft_options_create(options))
  call check(weft_options_set(options, "threads", 1))  ! the same bytes every time
  call check(weft_options_set(options, "hgrad", 1.5d0))
  call check(weft_mesh_read(input, mesh))
  call check(weft_metric_read(sizes, mesh, metric))
  call check(weft_adapt(mesh, metric, options, c_null_ptr, result))
  call check(weft_result_write(result, output))
  call check(weft_result_summary(result, summary))
  print "(a)", summary
  freed = weft_free(result) + weft_free(options) + weft_free(metric) + weft_free(mesh)

contains

  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status == weft_ok) return
    print "(a)", weft_error()
    error stop 1
  end subroutine check
end program adapt_file
