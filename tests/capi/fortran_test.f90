! The Fortran module passes arguments and results on as they are, with numbers from 1, and refuses what does not fit.
! Prints what is wrong; exit code 1 then.
program fortran_test
  use volccd
  use, intrinsic :: iso_fortran_env, only: int64
  implicit none
  integer, parameter :: dp = volccd_real
  integer, parameter :: tetrahedra(2) = volccd_tetrahedron, offsets(3) = [1, 5, 9]
  integer :: failures = 0, i
  integer, parameter :: connectivity(8) = [(i, i=1, 8)]
  real(dp) :: x0(3, 8), x1(3, 8)

  ! Two tetrahedra, of which the second falls onto the first.
  x0 = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, -1, -1, 2, 2, -1, 2, -1, 2, 2, 0, 0, 3] * 1.0_dp, [3, 8])
  x1 = x0
  x1(3, 5:) = x1(3, 5:) - 2
  call test_step()
  call test_options()
  call test_quadratic()
  call test_edit()
  call test_thickness()
  call test_refusals()
  if (failures /= 0) error stop 1

contains

  subroutine expect(good, what)
    logical, intent(in) :: good
    character(len=*), intent(in) :: what
    if (good) return
    print *, "FAILED: ", what
    failures = failures + 1
  end subroutine

  subroutine test_step()
    type(volccd_detector) :: detector
    type(volccd_contact), allocatable :: contacts(:)
    type(volccd_contact_end), allocatable :: ends(:)
    type(volccd_contact) :: earliest
    integer(volccd_id), allocatable :: pairs(:, :)
    logical :: found
    real(dp) :: value
    call expect(len(volccd_version()) >= 5, "version")
    call expect(size(detector%contacts()) == 0, "no contacts before there is a mesh")
    call detector%create(8, tetrahedra, offsets, connectivity, objects=[7, 8])
    call detector%step(x0, x1, ends=.true., initial_overlaps=.true.)
    contacts = detector%contacts()
    ends = detector%contact_ends()
    pairs = detector%initial_overlaps()
    call expect(size(contacts) > 0 .and. size(ends) == size(contacts), "contacts and their ends")
    call expect(size(pairs) == 0, "no overlaps")
    earliest = contacts(minloc(contacts%time, 1))
    call expect(earliest%kind == volccd_vf .and. all(earliest%vertices == [4, 5, 6, 7]), "vertices")
    call expect(all(earliest%elements == [1, 2]) .and. all(earliest%objects == [7, 8]), "elements and objects")
    call expect(abs(earliest%time - 0.5_dp) < 1e-8_dp, "time")
    call detector%statistic("contacts", value)
    call expect(nint(value) == size(contacts), "statistic")
    call detector%first(x0, x1, earliest, found)
    call expect(found .and. all(earliest%vertices == [4, 5, 6, 7]), "first")
    call detector%first(x0, x0, earliest, found)
    call expect(.not. found, "first of none")
    call detector%step(x0, x1, t_max=0.25_dp)
    call expect(size(detector%contacts()) == 0, "t_max")
    call detector%set_separation(0.8_dp)
    call detector%step(x0, x1, t_max=0.25_dp)
    call expect(size(detector%contacts()) > 0, "separation")
    call detector%step(x1, x1, initial_overlaps=.true.)
    pairs = detector%initial_overlaps()
    call expect(size(pairs, 2) == 1 .and. all(pairs(:, 1) == [1, 2]), "initial overlaps")
  end subroutine

  subroutine test_options()
    type(volccd_detector) :: detector
    type(volccd_options) :: options
    options%pipeline = "VolCCD"
    options%settings = "  element-culling=csat csat.axis=optimal "
    options%threads = 2
    options%excluded = reshape([7, 8], [2, 1])
    options%lists = volccd_lists_always
    options%list_budget = 1
    call detector%create(8, tetrahedra, offsets, connectivity, objects=[7, 8], options=options)
    call detector%step(x0, x1)
    call expect(size(detector%contacts()) == 0, "excluded objects")
    options%excluded = reshape([7, 9, 9, 9], [2, 2])
    call detector%create(8, tetrahedra, offsets, connectivity, objects=[7, 8], options=options)
    call detector%step(x0, x1)
    call expect(size(detector%contacts()) > 0, "others")
  end subroutine

  subroutine test_quadratic()
    type(volccd_detector) :: detector
    type(volccd_contact), allocatable :: contacts(:)
    real(dp) :: xm(3, 8)
    xm = x0
    call detector%create(8, tetrahedra, offsets, connectivity)
    call detector%step_quadratic(x0, xm, x1)
    contacts = detector%contacts()
    call expect(size(contacts) > 0, "quadratic")
    call expect(abs(minval(contacts%time) - sqrt(0.5_dp)) < 1e-8_dp, "accelerated from rest")
  end subroutine

  subroutine test_edit()
    type(volccd_detector) :: detector
    type(volccd_contact), allocatable :: contacts(:)
    real(dp) :: y0(3, 9), y1(3, 9)
    call detector%create(8, tetrahedra, offsets, connectivity, ids=[10_int64, 20_int64])
    call detector%edit(removed=[20_int64])
    call detector%step(x0, x1)
    call expect(size(detector%contacts()) == 0, "removed")
    call detector%edit(new_vertices=1, types=[volccd_tetrahedron], offsets=[1, 5], connectivity=[5, 6, 7, 9], &
                       ids=[30_int64], objects=[4])
    y0(:, :8) = x0
    y1(:, :8) = x1
    y0(:, 9) = [0, 0, 4]
    y1(:, 9) = [0, 0, 2]
    call detector%step(y0, y1)
    contacts = detector%contacts()
    call expect(size(contacts) > 0, "added")
    call expect(all(contacts(1)%elements == [10, 30]) .and. contacts(1)%objects(2) == 4, "added ids and objects")
  end subroutine

  subroutine test_thickness()
    type(volccd_detector) :: detector
    call detector%create(8, [volccd_triangle, volccd_triangle], [1, 4, 7], [1, 2, 3, 5, 6, 7], &
                         thickness=[0.1_dp, 0.1_dp])
    call detector%step(x0, x1)
    call expect(size(detector%contacts()) > 0, "of thickened shells")
  end subroutine

  subroutine expect_refused(detector, status, text)
    type(volccd_detector), intent(in) :: detector
    integer, intent(in) :: status
    character(len=*), intent(in) :: text
    call expect(status /= volccd_ok .and. index(detector%message(), text) > 0, &
                "refused: " // text // ", but: " // detector%message())
  end subroutine

  subroutine test_refusals()
    type(volccd_detector) :: detector
    type(volccd_options) :: options
    integer :: status
    real(dp) :: value
    call detector%step(x0, x1, status=status)
    call expect_refused(detector, status, "detector is NULL")
    call detector%create(8, tetrahedra, [1, 5], connectivity, status=status)
    call expect_refused(detector, status, "offsets")
    call detector%create(8, [10, 300], offsets, connectivity, status=status)
    call expect_refused(detector, status, "types")
    call detector%create(8, tetrahedra, offsets, connectivity, ids=[1_int64], status=status)
    call expect_refused(detector, status, "ids")
    call detector%create(8, tetrahedra, offsets, connectivity, objects=[1], status=status)
    call expect_refused(detector, status, "objects")
    call detector%create(8, tetrahedra, offsets, connectivity, thickness=[1.0_dp], status=status)
    call expect_refused(detector, status, "thickness")
    options%excluded = reshape([1, 2, 3], [3, 1])
    call detector%create(8, tetrahedra, offsets, connectivity, options=options, status=status)
    call expect_refused(detector, status, "excluded")
    options = volccd_options(pipeline="nonsense")
    call detector%create(8, tetrahedra, offsets, connectivity, options=options, status=status)
    call expect_refused(detector, status, "nonsense")
    call expect(status == volccd_error_config, "code")
    call detector%create(7, tetrahedra, offsets, connectivity, status=status)
    call expect(status == volccd_error_input, "a vertex out of range")
    call detector%create(8, tetrahedra, offsets, connectivity, status=status)
    call expect(status == volccd_ok, "status is set")
    call detector%step(x0(:, :7), x1(:, :7), status=status)
    call expect_refused(detector, status, "7 positions for 8 vertices")
    call detector%step(x0, x1(:, :7), status=status)
    call expect_refused(detector, status, "positions are not arrays")
    call detector%step_quadratic(x0, x0(:2, :), x1, status=status)
    call expect_refused(detector, status, "positions are not arrays")
    call detector%edit(types=[10], offsets=[1, 5], connectivity=[1, 2, 3, 4], status=status)
    call expect_refused(detector, status, "ids")
    call detector%edit(removed=[5_int64], status=status)
    call expect_refused(detector, status, "removed[0]")
    call detector%statistic("nonsense", value, status)
    call expect_refused(detector, status, "nonsense")
  end subroutine
end program
