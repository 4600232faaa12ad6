!> A box in parts, adapted to the sizes of another box in parts: the mesh of one process, whatever the ranks; and what
!> is wrong with the background on one rank all hear of. mpirun -n N parts_on_background
program parts_on_background
  use, intrinsic :: iso_c_binding
  use mpi
  use weft
  implicit none
  integer(c_int64_t), parameter :: prime = 2147483647_c_int64_t
  type(c_ptr) :: options = c_null_ptr, result = c_null_ptr, part = c_null_ptr, background = c_null_ptr, &
    metric = c_null_ptr, mesh = c_null_ptr, other = c_null_ptr
  integer(c_int64_t) :: tets, hash, tets_alone, hash_alone, points
  integer :: rank, ranks, ierr
  integer(c_int) :: status
  character(12) :: last
  character(:), allocatable :: text

  call MPI_Init(ierr)
  call MPI_Comm_rank(MPI_COMM_WORLD, rank, ierr)
  call MPI_Comm_size(MPI_COMM_WORLD, ranks, ierr)
  call check(weft_options_create(options))
  call check(weft_options_set(options, "threads", 1))
  call check(weft_options_set(options, "subdomains", 5))

  call adapt(MPI_COMM_WORLD, rank, ranks, tets, hash)
  call adapt(MPI_COMM_SELF, 0, 1, tets_alone, hash_alone)
  if (tets /= tets_alone .or. hash /= hash_alone) call fail("the mesh of several ranks is another one")
  call adapt_whole(tets_alone, hash_alone)
  if (tets /= tets_alone .or. hash /= hash_alone) call fail("the mesh that is not in parts is another one")

  ! The last rank alone gives one size too many.
  call make_part([4, 4, 4], rank, ranks, 0, part)
  call make_part([6, 5, 6], rank, ranks, merge(1, 0, rank == ranks - 1), background, metric)
  status = weft_adapt_parts_to_background(MPI_COMM_WORLD, part, background, metric, options, result)
  if (status /= weft_input_error) call fail("a metric of the wrong length is taken")
  text = weft_error()
  write (last, "(i0)") ranks - 1
  if (index(text, "background: rank "//trim(last)//": metric of another mesh: it has") /= 1) call fail(text)
  status = weft_adapt_parts_to_background(MPI_COMM_WORLD, part, c_null_ptr, metric, options, result)
  if (status /= weft_misuse .or. weft_error() /= "rank 0: background: is NULL, not a weft_part") call fail(weft_error())
  call check(weft_free(part) + weft_free(background) + weft_free(metric) + weft_free(options))
  if (rank == 0) print "(a, i0, a, i0)", "all: ", tets, " tets, hash ", hash
  call MPI_Finalize(ierr)

contains

  subroutine check(status)
    integer(c_int), intent(in) :: status
    if (status /= weft_ok) call fail(weft_error())
  end subroutine check

  subroutine fail(text)
    character(*), intent(in) :: text
    integer :: ierr
    print "(2a)", "FAILED: ", text
    call MPI_Abort(MPI_COMM_WORLD, 1, ierr)
  end subroutine fail

  !> Points, tets and sizes of a box.
  subroutine make_box(cells, mesh, points, tets, sizes)
    integer, intent(in) :: cells(3)
    type(c_ptr), intent(inout) :: mesh
    real(c_double), pointer, intent(out) :: points(:, :)
    integer(c_int64_t), allocatable, intent(inout) :: tets(:)
    real(c_double), allocatable, intent(out) :: sizes(:)
    call check(weft_mesh_box(int(cells, c_int64_t), mesh))
    call check(weft_mesh_points(mesh, points))
    call check(weft_mesh_get(mesh, weft_tets, tets))
    sizes = 0.1d0 + 0.1d0 * points(1, :)
  end subroutine make_box

  !> A rank's part of a box, every `ranks`-th block of 7 tets; `metric`: the sizes there, and `more` of them.
  subroutine make_part(cells, rank, ranks, more, part, metric)
    integer, intent(in) :: cells(3), rank, ranks, more
    type(c_ptr), intent(inout) :: part
    type(c_ptr), intent(inout), optional :: metric
    type(c_ptr) :: whole, mesh
    real(c_double), pointer :: x(:, :)
    real(c_double), allocatable :: sizes(:), local_x(:, :), local_sizes(:)
    integer(c_int64_t), allocatable :: list(:), all(:, :), mine(:, :), local(:), ids(:), tet_ids(:)
    integer(c_int64_t) :: t, i, v, points, tets
    whole = c_null_ptr
    mesh = c_null_ptr
    call make_box(cells, whole, x, list, sizes)
    all = reshape(list, [4, size(list) / 4])
    allocate (local(size(sizes)), ids(size(sizes)), mine(4, size(all, 2)), tet_ids(size(all, 2)))
    local = 0
    points = 0
    tets = 0
    do t = 1, size(all, 2)
      if (mod((t - 1) / 7, int(ranks, c_int64_t)) /= rank) cycle
      tets = tets + 1
      tet_ids(tets) = t - 1
      do i = 1, 4
        v = all(i, t)
        if (local(v) == 0) then
          points = points + 1
          local(v) = points
          ids(points) = v
        end if
        mine(i, tets) = local(v)
      end do
    end do
    local_x = x(:, ids(:points))
    call check(weft_mesh_create(local_x, mine(:, :tets), mesh))
    call check(weft_part_create(mesh, ids(:points), c_null_ptr, part, tet_ids(:tets)))
    if (present(metric)) then
      allocate (local_sizes(points + more))
      local_sizes = 1
      local_sizes(:points) = sizes(ids(:points))
      call check(weft_metric_from_sizes(local_sizes, metric))
    end if
    call check(weft_free(mesh) + weft_free(whole))
  end subroutine make_part

  !> How many tets all ranks have in the end, and a number that depends on all their points but not on their order.
  subroutine adapt(communicator, rank, ranks, tets, hash)
    integer, intent(in) :: communicator, rank, ranks
    integer(c_int64_t), intent(out) :: tets, hash
    call make_part([4, 4, 4], rank, ranks, 0, part)
    call make_part([6, 5, 6], rank, ranks, 0, background, metric)
    call check(weft_adapt_parts_to_background(communicator, part, background, metric, options, result))
    call check(weft_result_mesh(result, mesh))
    call hash_of(mesh, communicator, tets, hash)
    call check(weft_free(mesh) + weft_free(result) + weft_free(part) + weft_free(background) + weft_free(metric))
  end subroutine adapt

  !> The same of whole meshes.
  subroutine adapt_whole(tets, hash)
    integer(c_int64_t), intent(out) :: tets, hash
    real(c_double), pointer :: x(:, :)
    real(c_double), allocatable :: sizes(:), kept(:, :)
    integer(c_int64_t), allocatable :: list(:)
    type(c_ptr) :: box
    box = c_null_ptr
    call make_box([4, 4, 4], box, x, list, sizes)
    kept = x
    call check(weft_mesh_create(kept, reshape(list, [4, size(list) / 4]), mesh))
    call check(weft_free(box))
    call make_box([6, 5, 6], box, x, list, sizes)
    kept = x
    call check(weft_mesh_create(kept, reshape(list, [4, size(list) / 4]), other))
    call check(weft_metric_from_sizes(sizes, metric))
    call check(weft_adapt_to_background(mesh, other, metric, options, c_null_ptr, result))
    call check(weft_free(box) + weft_free(mesh))
    call check(weft_result_mesh(result, mesh))
    call hash_of(mesh, MPI_COMM_SELF, tets, hash)
    call check(weft_free(mesh) + weft_free(other) + weft_free(result) + weft_free(metric))
  end subroutine adapt_whole

  subroutine hash_of(mesh, communicator, tets, hash)
    type(c_ptr), intent(in) :: mesh
    integer, intent(in) :: communicator
    integer(c_int64_t), intent(out) :: tets, hash
    real(c_double), pointer :: x(:, :)
    integer(c_int64_t), allocatable :: list(:), of_point(:)
    integer(c_int64_t) :: mine(2), all(2), of_tet
    integer :: t, i, ierr
    call check(weft_mesh_points(mesh, x))
    call check(weft_mesh_get(mesh, weft_tets, list))
    call check(weft_mesh_num_points(mesh, points))
    allocate (of_point(points))
    do i = 1, size(of_point)
      of_point(i) = hash_of_point(x(:, i))
    end do
    mine = 0
    do t = 0, size(list) / 4 - 1
      of_tet = 1
      do i = 1, 4
        of_tet = mod(of_tet * of_point(list(4 * t + i)), prime)
      end do
      mine(1) = mine(1) + 1
      mine(2) = mine(2) + of_tet
    end do
    call MPI_Allreduce(mine, all, 2, MPI_INTEGER8, MPI_SUM, communicator, ierr)
    tets = all(1)
    hash = all(2)
  end subroutine hash_of

  !> All bits of the three coordinates, from 1 to prime - 1.
  pure function hash_of_point(x) result(hash)
    real(c_double), intent(in) :: x(3)
    integer(c_int64_t) :: hash, bits
    integer :: axis
    hash = 1
    do axis = 1, 3
      bits = transfer(x(axis), bits)
      hash = mod(hash * 1103515245_c_int64_t + iand(bits, 4294967295_c_int64_t), prime)
      hash = mod(hash * 1103515245_c_int64_t + iand(ishft(bits, -32), 4294967295_c_int64_t), prime)
    end do
    hash = max(hash, 1_c_int64_t)
  end function hash_of_point
end program parts_on_background
