! A cube of springs falls onto a fixed plate and bounces: an explicit loop with penalty forces from the contacts that
! the library finds. Prints the contacts of each twentieth step and, at the end, totals. docs/into_a_solver.md explains
! it; examples/c/bouncing_cube.c prints the same.
program bouncing_cube
  use volccd
  implicit none
  integer, parameter :: dp = volccd_real, plate = 8, vertices = 16, steps = 400
  real(dp), parameter :: h = 1e-3_dp, mass = 1, gravity = -9.81_dp
  real(dp), parameter :: stiffness = 2e4_dp, penalty = 4e3_dp, separation = 0.05_dp
  real(dp) :: rest(3, vertices), x0(3, vertices), x1(3, vertices), v(3, vertices), force(3, vertices)
  type(volccd_detector) :: detector
  type(volccd_contact), allocatable :: contacts(:)
  type(volccd_contact_end), allocatable :: ends(:)
  integer :: step, k, total

  rest(:, :plate) = box([-2.0_dp, -2.0_dp, -1.0_dp], [2.0_dp, 2.0_dp, 0.0_dp])
  rest(:, plate + 1:) = box([-0.5_dp, -0.4_dp, 0.12_dp], [0.5_dp, 0.6_dp, 1.12_dp])
  x0 = rest
  v = 0
  total = 0
  call make_detector()
  do step = 0, steps - 1
    x1 = x0 + h * v
    call detector%step(x0, x1, ends=.true.)
    contacts = detector%contacts()
    ends = detector%contact_ends()
    force = 0
    call add_springs()
    do k = 1, size(contacts)
      call add_contact(contacts(k), ends(k))
      if (mod(step, 20) == 0) call print_contact(contacts(k), ends(k))
    end do
    total = total + size(contacts)
    force(:, plate + 1:) = force(:, plate + 1:) / mass
    force(3, plate + 1:) = force(3, plate + 1:) + gravity
    v(:, plate + 1:) = v(:, plate + 1:) + h * force(:, plate + 1:)  ! the plate is fixed
    x0 = x1
  end do
  print "(i0, a, f8.6)", total, " contacts, height ", x0(3, plate + 1)

contains

  ! A box of one hexahedron in VTK's node order.
  function box(low, high) result(x)
    real(dp), intent(in) :: low(3), high(3)
    real(dp) :: x(3, 8)
    logical, parameter :: f = .false., t = .true.
    logical, parameter :: is_high(3, 8) = reshape([f, f, f, t, f, f, t, t, f, f, t, f, &
                                                   f, f, t, t, f, t, t, t, t, f, t, t], [3, 8])
    x = merge(spread(high, 2, 8), spread(low, 2, 8), is_high)
  end function

  subroutine make_detector()
    type(volccd_options) :: options
    integer :: i
    options%separation = separation
    options%pairs = volccd_pairs_inter
    options%lists = volccd_lists_auto
    call detector%create(vertices, types=[volccd_hexahedron, volccd_hexahedron], offsets=[1, 9, 17], &
                         connectivity=[(i, i=1, vertices)], objects=[1, 2], options=options)
  end subroutine

  ! A spring between each two vertices of the cube. They are linear in the change of the distance vector, which suits a
  ! cube that hardly turns.
  subroutine add_springs()
    real(dp) :: pull(3)
    integer :: a, b
    do a = plate + 1, vertices
      do b = a + 1, vertices
        pull = stiffness * ((x1(:, b) - x1(:, a)) - (rest(:, b) - rest(:, a)))
        force(:, a) = force(:, a) + pull
        force(:, b) = force(:, b) - pull
      end do
    end do
  end subroutine

  ! The force on the first feature is along the normal, proportional to what lacks to the separation at the end of the
  ! step; the weights of the contact share it among the vertices. The second feature gets the opposite force.
  subroutine add_contact(contact, at_end)
    type(volccd_contact), intent(in) :: contact
    type(volccd_contact_end), intent(in) :: at_end
    real(dp) :: size
    integer :: first, i
    size = penalty * (separation - at_end%gap)
    if (size <= 0) return
    first = merge(1, 2, contact%kind == volccd_vf)  ! vertices of the first feature
    do i = 1, 4
      associate (v => contact%vertices(i))
        force(:, v) = force(:, v) + merge(size, -size, i <= first) * contact%weights(i) * contact%normal
      end associate
    end do
  end subroutine

  ! Numbers of vertices begin with 0, as the version in C prints them.
  subroutine print_contact(contact, at_end)
    type(volccd_contact), intent(in) :: contact
    type(volccd_contact_end), intent(in) :: at_end
    print "(i0, 1x, a, 4(1x, i0), a, f8.6, a, f8.6, a, 3(1x, f6.3))", step, &
      merge("VF", "EE", contact%kind == volccd_vf), contact%vertices - 1, "  time ", contact%time, "  end gap ", &
      at_end%gap, "  normal", contact%normal
  end subroutine
end program
