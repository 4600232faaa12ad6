!> Adapts a box that the ranks have slabs of, on a communicator of the program's own: mpirun -n 4 adapt_parts
program adapt_parts
  use, intrinsic :: iso_c_binding
  use mpi
  use weft
  implicit none
  integer, parameter :: cells = 6, side = cells + 1
  ! Six tets round the diagonal of a cell, by its corners in binary.
  integer, parameter :: tets_of_cell(4, 6) = reshape( &
    [0, 1, 3, 7, 0, 3, 2, 7, 0, 2, 6, 7, 0, 6, 4, 7, 0, 4, 5, 7, 0, 5, 1, 7], [4, 6])
  type(c_ptr) :: mesh = c_null_ptr, metric = c_null_ptr, part = c_null_ptr, options = c_null_ptr, &
    result = c_null_ptr
  type(weft_measures) :: measures
  integer :: world_rank, rank, ranks, holders, solvers, ierr
  integer(c_int) :: status, freed

  call MPI_Init(ierr)
  call MPI_Comm_rank(MPI_COMM_WORLD, world_rank, ierr)
  call MPI_Comm_split(MPI_COMM_WORLD, 0, -world_rank, solvers, ierr)  ! the ranks in the opposite order
  call MPI_Comm_rank(solvers, rank, ierr)
  call MPI_Comm_size(solvers, ranks, ierr)

  ! The last of several ranks has nothing. A rank that fails here has a c_null_ptr as part: then all get an error.
  holders = max(ranks - 1, 1)
  call make_slab(cells * min(rank, holders) / holders, cells * min(rank + 1, holders) / holders)
  status = weft_options_create(options)
  status = weft_options_set(options, "threads", 1)
  status = weft_options_set(options, "subdomains", 4)
  status = weft_adapt_parts(solvers, part, metric, options, result)
  if (status == weft_ok) status = weft_result_measures(result, measures)
  if (status /= weft_ok) print "(a, i0, 2a)", "rank ", rank, ": ", weft_error()
  if (status == weft_ok .and. rank == 0) &
    print "(a, i0, a, f0.9)", "all: ", measures%tets, " tets, volume ", measures%volume

  freed = weft_free(result) + weft_free(options) + weft_free(metric) + weft_free(part) + weft_free(mesh)
  call MPI_Comm_free(solvers, ierr)
  call MPI_Finalize(ierr)
  if (status /= weft_ok) error stop 1

contains

  !> The layers of cells from `first` up to `last`, as a part: ids are those of the points of the whole box.
  subroutine make_slab(first, last)
    integer, intent(in) :: first, last
    real(c_double), allocatable :: points(:, :), sizes(:)
    integer(c_int64_t), allocatable :: tets(:, :), ids(:)
    integer :: layers, p, t, i, x, y, z, cell, corner
    layers = last - first
    p = merge((layers + 1) * side**2, 0, layers > 0)
    t = 6 * layers * cells**2
    allocate (points(3, p), sizes(p), ids(p), tets(4, t))
    do p = 1, size(ids)
      ids(p) = p - 1 + first * side**2
      points(:, p) = [mod(ids(p), int(side, c_int64_t)), mod(ids(p) / side, int(side, c_int64_t)), &
                      ids(p) / side**2] / real(cells, c_double)
    end do
    sizes = 0.12d0
    do t = 1, size(tets, 2)
      cell = (t - 1) / 6
      do i = 1, 4
        corner = tets_of_cell(i, mod(t - 1, 6) + 1)
        x = mod(cell, cells) + mod(corner, 2)
        y = mod(cell / cells, cells) + mod(corner / 2, 2)
        z = cell / cells**2 + corner / 4
        tets(i, t) = 1 + x + side * (y + side * z)
      end do
    end do
    status = weft_mesh_create(points, tets, mesh)
    if (status == weft_ok) status = weft_part_create(mesh, ids, c_null_ptr, part)
    if (status == weft_ok) status = weft_metric_from_sizes(sizes, metric)
    if (status /= weft_ok) print "(a)", weft_error()
  end subroutine make_slab
end program adapt_parts
