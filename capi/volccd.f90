! The library for Fortran 2008, on its interface for C. volccd.h says what arguments mean and which errors there are;
! here, numbers of vertices and positions in arrays begin with 1, and the ids of elements without ids are 1, 2, ...
! There are no polyhedra.
!
! Every subroutine has an optional last argument `status`: volccd_ok or the code of an error, whose message
! detector%message() has. Without it, an error ends the program with exit code 2 and the message on the error unit.
!
! Numbers in messages begin with 0, as in C.
!
! Threads: a detector is used by one thread at a time; different detectors are independent. Arrays of results are
! copies; before the first step they are empty.
module volccd
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: error_unit
  implicit none
  private

  ! Kinds of positions and of ids.
  integer, parameter, public :: volccd_real = c_double, volccd_id = c_int64_t

  public :: volccd_options, volccd_contact, volccd_contact_end, volccd_detector
  public :: volccd_version

  ! Codes of errors (volccd.h).
  integer, parameter, public :: volccd_ok = 0, volccd_error_argument = 1, volccd_error_input = 2, &
    volccd_error_config = 3, volccd_error_memory = 4, volccd_error_internal = 5
  ! Types of cells, those of VTK.
  integer, parameter, public :: volccd_triangle = 5, volccd_quad = 9, volccd_tetrahedron = 10, volccd_hexahedron = 12, &
    volccd_wedge = 13, volccd_pyramid = 14
  integer, parameter, public :: volccd_pairs_all = 0, volccd_pairs_inter = 1, volccd_pairs_intra = 2
  integer, parameter, public :: volccd_edges_triangulated = 0, volccd_edges_polytope = 1
  integer, parameter, public :: volccd_lists_never = 0, volccd_lists_auto = 1, volccd_lists_always = 2
  integer, parameter, public :: volccd_vf = 0, volccd_ee = 1

  ! How contacts are found; members as in volccd.h.
  type :: volccd_options
    character(len=:), allocatable :: pipeline                         ! "VolCCD+" if it is not set
    character(len=:), allocatable :: settings                         ! "element-culling=csat csat.axis=optimal"
    integer :: threads = 0                                            ! 0: as many as the hardware has
    integer :: pairs = volccd_pairs_all
    real(c_double) :: separation = 0
    integer, allocatable :: excluded(:, :)                            ! (2, n) pairs of objects without contacts
    integer :: edges = volccd_edges_triangulated
    integer :: lists = volccd_lists_never
    real(c_double) :: list_budget = 0, list_steps = 0
  end type

  type, bind(c) :: volccd_contact
    integer(c_int32_t) :: kind                                        ! volccd_vf or volccd_ee
    integer(c_int32_t) :: at_start                                    ! 1 if the features touch at time 0
    integer(c_int64_t) :: vertices(4)                                 ! thickened shells: v stems from (v - 1) / 3 + 1
    integer(c_int64_t) :: elements(2)                                 ! ids
    integer(c_int32_t) :: objects(2)
    real(c_double) :: time
    real(c_double) :: normal(3), point(3), weights(4)
    real(c_double) :: gap
  end type

  type, bind(c) :: volccd_contact_end
    real(c_double) :: gap
    real(c_double) :: weights(4), first(3), second(3)
  end type

  ! A mesh with the pipeline and its tables. Freed when it goes out of scope; not to be copied.
  type :: volccd_detector
    private
    type(c_ptr) :: handle = c_null_ptr
    character(len=:), allocatable :: text
  contains
    procedure :: message
    procedure :: create, edit, set_separation, step, step_quadratic, first
    procedure :: contacts, contact_ends, initial_overlaps, statistic
    procedure :: free
    final :: finalize
  end type

  ! The structs of volccd.h.
  type, bind(c) :: c_cells
    integer(c_int64_t) :: count = 0
    type(c_ptr) :: types = c_null_ptr, offsets = c_null_ptr, connectivity = c_null_ptr
    integer(c_int64_t) :: connectivity_size = 0
    type(c_ptr) :: ids = c_null_ptr, objects = c_null_ptr, face_offsets = c_null_ptr, faces = c_null_ptr
    integer(c_int64_t) :: faces_size = 0
    type(c_ptr) :: thickness = c_null_ptr
  end type

  type, bind(c) :: c_options
    type(c_ptr) :: pipeline = c_null_ptr, settings = c_null_ptr
    integer(c_int64_t) :: setting_count = 0
    integer(c_int32_t) :: threads = 0, pairs = 0
    real(c_double) :: separation = 0
    type(c_ptr) :: excluded = c_null_ptr
    integer(c_int64_t) :: excluded_count = 0
    integer(c_int32_t) :: edges = 0, lists = 0
    real(c_double) :: list_budget = 0, list_steps = 0
  end type

  ! Arrays of cells as C has them, which outlive the call that they are passed to.
  type :: cell_storage
    integer(c_int8_t), allocatable :: types(:)
    integer(c_int64_t), allocatable :: offsets(:), connectivity(:), ids(:)
    integer(c_int32_t), allocatable :: objects(:)
    real(c_double), allocatable :: thickness(:)
  end type

  ! The same for options.
  type :: option_storage
    type(c_options) :: options
    character(kind=c_char), allocatable :: pipeline(:), text(:)
    type(c_ptr), allocatable :: settings(:)
    integer(c_int32_t), allocatable :: excluded(:, :)
  end type

  interface
    function c_last_error() bind(c, name="volccd_last_error")
      import :: c_ptr
      type(c_ptr) :: c_last_error
    end function
    function c_version() bind(c, name="volccd_version")
      import :: c_ptr
      type(c_ptr) :: c_version
    end function
    integer(c_int) function c_create(vertex_count, cells, options, detector) bind(c, name="volccd_create")
      import :: c_int, c_int64_t, c_ptr, c_cells, c_options
      integer(c_int64_t), value :: vertex_count
      type(c_cells) :: cells
      type(c_options) :: options
      type(c_ptr) :: detector
    end function
    subroutine c_free(detector) bind(c, name="volccd_free")
      import :: c_ptr
      type(c_ptr), value :: detector
    end subroutine
    integer(c_int) function c_edit(detector, removed, removed_count, new_vertices, added) bind(c, name="volccd_edit")
      import :: c_int, c_int64_t, c_ptr, c_cells
      type(c_ptr), value :: detector
      integer(c_int64_t) :: removed(*)
      integer(c_int64_t), value :: removed_count, new_vertices
      type(c_cells) :: added
    end function
    integer(c_int) function c_set_separation(detector, separation) bind(c, name="volccd_set_separation")
      import :: c_int, c_ptr, c_double
      type(c_ptr), value :: detector
      real(c_double), value :: separation
    end function
    integer(c_int) function c_step(detector, vertex_count, x0, x1, flags, t_max) bind(c, name="volccd_step")
      import :: c_int, c_int32_t, c_int64_t, c_ptr, c_double
      type(c_ptr), value :: detector
      integer(c_int64_t), value :: vertex_count
      real(c_double), intent(in) :: x0(3, *), x1(3, *)
      integer(c_int32_t), value :: flags
      real(c_double), value :: t_max
    end function
    integer(c_int) function c_step_quadratic(detector, vertex_count, x0, xm, x1, flags, t_max) &
      bind(c, name="volccd_step_quadratic")
      import :: c_int, c_int32_t, c_int64_t, c_ptr, c_double
      type(c_ptr), value :: detector
      integer(c_int64_t), value :: vertex_count
      real(c_double), intent(in) :: x0(3, *), xm(3, *), x1(3, *)
      integer(c_int32_t), value :: flags
      real(c_double), value :: t_max
    end function
    integer(c_int) function c_first(detector, vertex_count, x0, x1, contact, found) bind(c, name="volccd_first")
      import :: c_int, c_int32_t, c_int64_t, c_ptr, c_double, volccd_contact
      type(c_ptr), value :: detector
      integer(c_int64_t), value :: vertex_count
      real(c_double), intent(in) :: x0(3, *), x1(3, *)
      type(volccd_contact) :: contact
      integer(c_int32_t) :: found
    end function
    integer(c_int) function c_contacts(detector, entries, count) bind(c, name="volccd_contacts")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: detector
      type(c_ptr) :: entries
      integer(c_int64_t) :: count
    end function
    integer(c_int) function c_contact_ends(detector, entries, count) bind(c, name="volccd_contact_ends")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: detector
      type(c_ptr) :: entries
      integer(c_int64_t) :: count
    end function
    integer(c_int) function c_initial_overlaps(detector, entries, count) bind(c, name="volccd_initial_overlaps")
      import :: c_int, c_int64_t, c_ptr
      type(c_ptr), value :: detector
      type(c_ptr) :: entries
      integer(c_int64_t) :: count
    end function
    integer(c_int) function c_statistic_value(detector, name, value) bind(c, name="volccd_statistic_value")
      import :: c_int, c_ptr, c_double, c_char
      type(c_ptr), value :: detector
      character(kind=c_char), intent(in) :: name(*)
      real(c_double) :: value
    end function
    integer(c_size_t) function c_strlen(text) bind(c, name="strlen")
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function
  end interface

contains

  function volccd_version() result(version)
    character(len=:), allocatable :: version
    version = text_of(c_version())
  end function

  ! The message of the last call with this detector that failed; empty if none did.
  function message(self)
    class(volccd_detector), intent(in) :: self
    character(len=:), allocatable :: message
    message = ""
    if (allocated(self%text)) message = self%text
  end function

  ! Makes the detector for a mesh; frees what it was before. Cell i has the type types(i) and the vertices
  ! connectivity(offsets(i) : offsets(i + 1) - 1).
  subroutine create(self, vertex_count, types, offsets, connectivity, ids, objects, thickness, options, status)
    class(volccd_detector), intent(inout) :: self
    integer, intent(in) :: vertex_count, types(:), offsets(:), connectivity(:)
    integer(c_int64_t), intent(in), optional :: ids(:)
    integer, intent(in), optional :: objects(:)
    real(c_double), intent(in), optional :: thickness(:)
    type(volccd_options), intent(in), optional :: options
    integer, intent(out), optional :: status
    type(cell_storage), target :: storage
    type(option_storage), target :: chosen

    call self%free()
    if (.not. store_cells(self, storage, types, offsets, connectivity, ids, objects, thickness, status)) return
    if (present(options)) then
      if (allocated(options%excluded)) then
        if (size(options%excluded, 1) /= 2) then
          call refuse(self, "options: excluded is not an array (2, n)", status)
          return
        end if
      end if
      call store_options(chosen, options)
    end if
    call report(self, c_create(int(vertex_count, c_int64_t), cells_of(storage), chosen%options, self%handle), status)
  end subroutine

  ! Changes the mesh between two steps: removes elements by their ids, appends vertices, adds cells, which need ids.
  subroutine edit(self, removed, new_vertices, types, offsets, connectivity, ids, objects, thickness, status)
    class(volccd_detector), intent(inout) :: self
    integer(c_int64_t), intent(in), optional :: removed(:)
    integer, intent(in), optional :: new_vertices, types(:), offsets(:), connectivity(:)
    integer(c_int64_t), intent(in), optional :: ids(:)
    integer, intent(in), optional :: objects(:)
    real(c_double), intent(in), optional :: thickness(:)
    integer, intent(out), optional :: status
    type(cell_storage), target :: storage
    type(c_cells) :: added
    integer(c_int64_t), allocatable :: gone(:)
    integer(c_int64_t) :: vertices

    allocate (gone(0))
    if (present(removed)) gone = removed
    vertices = 0
    if (present(new_vertices)) vertices = new_vertices
    if (present(types)) then
      if (.not. (present(offsets) .and. present(connectivity) .and. present(ids))) then
        call refuse(self, "edit: added cells need offsets, connectivity and ids", status)
        return
      end if
      if (.not. store_cells(self, storage, types, offsets, connectivity, ids, objects, thickness, status)) return
      added = cells_of(storage)
    end if
    call report(self, c_edit(self%handle, gone, size(gone, kind=c_int64_t), vertices, added), status)
  end subroutine

  subroutine set_separation(self, separation, status)
    class(volccd_detector), intent(inout) :: self
    real(c_double), intent(in) :: separation
    integer, intent(out), optional :: status
    call report(self, c_set_separation(self%handle, separation), status)
  end subroutine

  ! Finds the contacts of the motion from x0 to x1, (3, vertices) each.
  subroutine step(self, x0, x1, ends, initial_overlaps, t_max, status)
    class(volccd_detector), intent(inout) :: self
    real(c_double), intent(in), contiguous :: x0(:, :), x1(:, :)
    logical, intent(in), optional :: ends, initial_overlaps
    real(c_double), intent(in), optional :: t_max
    integer, intent(out), optional :: status
    if (.not. is_motion(self, "step", x0, x1, status=status)) return
    call report(self, c_step(self%handle, size(x0, 2, c_int64_t), x0, x1, flags_of(ends, initial_overlaps), &
                             latest(t_max)), status)
  end subroutine

  ! The same on quadratic Bezier curves with the middle control points xm.
  subroutine step_quadratic(self, x0, xm, x1, ends, initial_overlaps, t_max, status)
    class(volccd_detector), intent(inout) :: self
    real(c_double), intent(in), contiguous :: x0(:, :), xm(:, :), x1(:, :)
    logical, intent(in), optional :: ends, initial_overlaps
    real(c_double), intent(in), optional :: t_max
    integer, intent(out), optional :: status
    if (.not. is_motion(self, "step_quadratic", x0, x1, xm, status)) return
    call report(self, c_step_quadratic(self%handle, size(x0, 2, c_int64_t), x0, xm, x1, &
                                       flags_of(ends, initial_overlaps), latest(t_max)), status)
  end subroutine

  ! The earliest contact of the motion, if `found`; its results replace those of the last step.
  subroutine first(self, x0, x1, contact, found, status)
    class(volccd_detector), intent(inout) :: self
    real(c_double), intent(in), contiguous :: x0(:, :), x1(:, :)
    type(volccd_contact), intent(inout) :: contact
    logical, intent(out) :: found
    integer, intent(out), optional :: status
    integer(c_int32_t) :: is_found
    found = .false.
    is_found = 0
    if (.not. is_motion(self, "first", x0, x1, status=status)) return
    call report(self, c_first(self%handle, size(x0, 2, c_int64_t), x0, x1, contact, is_found), status)
    found = is_found /= 0
    if (found) contact%vertices = contact%vertices + 1
  end subroutine

  ! The contacts of the last step, in canonical order.
  function contacts(self) result(list)
    class(volccd_detector), intent(in) :: self
    type(volccd_contact), allocatable :: list(:)
    type(c_ptr) :: entries
    integer(c_int64_t) :: n
    n = 0
    if (c_contacts(self%handle, entries, n) /= volccd_ok) n = 0
    list = contacts_of(entries, n)
  end function

  ! Of each contact, if the last step had ends=.true.: the features at time 1.
  function contact_ends(self) result(list)
    class(volccd_detector), intent(in) :: self
    type(volccd_contact_end), allocatable :: list(:)
    type(volccd_contact_end), pointer :: all(:)
    type(c_ptr) :: entries
    integer(c_int64_t) :: n
    n = 0
    if (c_contact_ends(self%handle, entries, n) /= volccd_ok) n = 0
    allocate (list(n))
    if (n == 0) return
    call c_f_pointer(entries, all, [n])
    list = all
  end function

  ! If the last step had initial_overlaps=.true.: ids of elements that overlap at time 0, (2, n).
  function initial_overlaps(self) result(pairs)
    class(volccd_detector), intent(in) :: self
    integer(c_int64_t), allocatable :: pairs(:, :)
    integer(c_int64_t), pointer :: all(:, :)
    type(c_ptr) :: entries
    integer(c_int64_t) :: n
    n = 0
    if (c_initial_overlaps(self%handle, entries, n) /= volccd_ok) n = 0
    allocate (pairs(2, n))
    if (n == 0) return
    call c_f_pointer(entries, all, [2_c_int64_t, n])
    pairs = all
  end function

  ! A count or time of the last step by its name in stats.json: "contacts", "earliest_toi", ...
  subroutine statistic(self, name, value, status)
    class(volccd_detector), intent(inout) :: self
    character(len=*), intent(in) :: name
    real(c_double), intent(inout) :: value
    integer, intent(out), optional :: status
    call report(self, c_statistic_value(self%handle, trim(name) // c_null_char, value), status)
  end subroutine

  ! Frees the mesh and all tables; the detector can be created again.
  subroutine free(self)
    class(volccd_detector), intent(inout) :: self
    call c_free(self%handle)
    self%handle = c_null_ptr
  end subroutine

  subroutine finalize(self)
    type(volccd_detector), intent(inout) :: self
    call self%free()
  end subroutine

  ! What follows is of this module alone.

  subroutine report(self, code, status)
    class(volccd_detector), intent(inout) :: self
    integer(c_int), intent(in) :: code
    integer, intent(out), optional :: status
    if (present(status)) status = code
    if (code == volccd_ok) return
    self%text = text_of(c_last_error())
    if (.not. present(status)) call stop_with(self%text)
  end subroutine

  ! An argument that the module itself refuses.
  subroutine refuse(self, text, status)
    class(volccd_detector), intent(inout) :: self
    character(len=*), intent(in) :: text
    integer, intent(out), optional :: status
    self%text = text
    if (.not. present(status)) call stop_with(text)
    status = volccd_error_argument
  end subroutine

  subroutine stop_with(text)
    character(len=*), intent(in) :: text
    write (error_unit, "(2a)") "volccd: ", text
    error stop 2
  end subroutine

  function text_of(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: all(:)
    integer :: i
    call c_f_pointer(pointer, all, [c_strlen(pointer)])
    allocate (character(len=size(all)) :: text)
    do i = 1, size(all)
      text(i:i) = all(i)
    end do
  end function

  function characters(text) result(list)
    character(len=*), intent(in) :: text
    character(kind=c_char) :: list(len(text) + 1)
    integer :: i
    do i = 1, len(text)
      list(i) = text(i:i)
    end do
    list(size(list)) = c_null_char
  end function

  ! Whether the arrays have 3 rows and as many columns as each other.
  logical function is_motion(self, name, x0, x1, xm, status)
    class(volccd_detector), intent(inout) :: self
    character(len=*), intent(in) :: name
    real(c_double), intent(in) :: x0(:, :), x1(:, :)
    real(c_double), intent(in), optional :: xm(:, :)
    integer, intent(out), optional :: status
    is_motion = size(x0, 1) == 3 .and. all(shape(x1) == shape(x0))
    if (present(xm)) is_motion = is_motion .and. all(shape(xm) == shape(x0))
    if (.not. is_motion) call refuse(self, name // ": positions are not arrays (3, n) of one n", status)
  end function

  integer(c_int32_t) function flags_of(ends, initial_overlaps)
    logical, intent(in), optional :: ends, initial_overlaps
    flags_of = 0
    if (present(initial_overlaps)) flags_of = merge(2, 0, initial_overlaps)
    if (present(ends)) flags_of = flags_of + merge(4, 0, ends)
  end function

  real(c_double) function latest(t_max)
    real(c_double), intent(in), optional :: t_max
    latest = 1
    if (present(t_max)) latest = t_max
  end function

  function contacts_of(entries, n) result(list)
    type(c_ptr), intent(in) :: entries
    integer(c_int64_t), intent(in) :: n
    type(volccd_contact), allocatable :: list(:)
    type(volccd_contact), pointer :: all(:)
    integer(c_int64_t) :: i
    allocate (list(n))
    if (n == 0) return
    call c_f_pointer(entries, all, [n])
    list = all
    do i = 1, n
      list(i)%vertices = list(i)%vertices + 1
    end do
  end function

  ! Copies the arrays as C has them. False if their lengths do not agree, or a number does not fit.
  logical function store_cells(self, storage, types, offsets, connectivity, ids, objects, thickness, status)
    class(volccd_detector), intent(inout) :: self
    type(cell_storage), intent(out) :: storage
    integer, intent(in) :: types(:), offsets(:), connectivity(:)
    integer(c_int64_t), intent(in), optional :: ids(:)
    integer, intent(in), optional :: objects(:)
    real(c_double), intent(in), optional :: thickness(:)
    integer, intent(out), optional :: status
    character(len=:), allocatable :: wrong
    integer :: i, n
    n = size(types)
    if (size(offsets) /= n + 1) wrong = "offsets: one more than types is needed"
    if (present(ids)) then
      if (size(ids) /= n) wrong = "ids: one for each cell is needed"
    end if
    if (present(objects)) then
      if (size(objects) /= n) wrong = "objects: one for each cell is needed"
    end if
    if (present(thickness)) then
      if (size(thickness) /= n) wrong = "thickness: one for each cell is needed"
    end if
    if (any(types < 0 .or. types > 127)) wrong = "types: not a type of a cell"
    store_cells = .not. allocated(wrong)
    if (.not. store_cells) then
      call refuse(self, wrong, status)
      return
    end if
    storage%types = int(types, c_int8_t)
    storage%offsets = int(offsets, c_int64_t) - 1
    storage%connectivity = int(connectivity, c_int64_t) - 1
    storage%ids = [(int(i, c_int64_t), i=1, n)]
    if (present(ids)) storage%ids = ids
    if (present(objects)) storage%objects = int(objects, c_int32_t)
    if (present(thickness)) storage%thickness = thickness
  end function

  function cells_of(storage) result(cells)
    type(cell_storage), intent(in), target :: storage
    type(c_cells) :: cells
    cells%count = size(storage%types, kind=c_int64_t)
    cells%types = c_loc(storage%types)
    cells%offsets = c_loc(storage%offsets)
    cells%connectivity = c_loc(storage%connectivity)
    cells%connectivity_size = size(storage%connectivity, kind=c_int64_t)
    cells%ids = c_loc(storage%ids)
    if (allocated(storage%objects)) cells%objects = c_loc(storage%objects)
    if (allocated(storage%thickness)) cells%thickness = c_loc(storage%thickness)
  end function

  subroutine store_options(storage, options)
    type(option_storage), intent(inout), target :: storage
    type(volccd_options), intent(in) :: options
    if (allocated(options%pipeline)) then
      storage%pipeline = characters(trim(options%pipeline))
      storage%options%pipeline = c_loc(storage%pipeline)
    end if
    if (allocated(options%settings)) call store_settings(storage, options%settings)
    if (allocated(options%excluded)) then
      storage%excluded = int(options%excluded, c_int32_t)
      storage%options%excluded = c_loc(storage%excluded)
      storage%options%excluded_count = size(storage%excluded, kind=c_int64_t) / 2
    end if
    storage%options%threads = options%threads
    storage%options%pairs = options%pairs
    storage%options%separation = options%separation
    storage%options%edges = options%edges
    storage%options%lists = options%lists
    storage%options%list_budget = options%list_budget
    storage%options%list_steps = options%list_steps
  end subroutine

  ! Each word ends with a null character in `text`, and `settings` has pointers to the words.
  subroutine store_settings(storage, settings)
    type(option_storage), intent(inout), target :: storage
    character(len=*), intent(in) :: settings
    integer :: i, n
    logical :: in_word
    storage%text = characters(settings)
    allocate (storage%settings(len(settings)))
    n = 0
    in_word = .false.
    do i = 1, len(settings)
      if (settings(i:i) == " ") then
        storage%text(i) = c_null_char
      else if (.not. in_word) then
        n = n + 1
        storage%settings(n) = c_loc(storage%text(i))
      end if
      in_word = settings(i:i) /= " "
    end do
    storage%options%settings = c_loc(storage%settings)
    storage%options%setting_count = n
  end subroutine
end module volccd
