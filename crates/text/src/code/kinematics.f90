
  ! The rates v that the drivers prescribe: Phi_q v = -Phi_t.
  subroutine @NAME@_velocities(t, p, u, f, q, v)
    real(real64), intent(in) :: t, p(@P@), u(@U@), f(@F@), q(@N@)
    real(real64), intent(inout) :: v(@N@)
    ! The loop equations that determine the motion, in this order.
    integer, parameter :: rows(@N@) = [@ROWS@]
    real(real64) :: mass(@N@, @N@), load(@N@), phi(@M@), phi_q(@M@, @N@), phi_t(@M@), gamma(@M@), matrix(@N@, @N@)
    v = 0.0_real64
    call @NAME@_equations(t, p, u, f, q, v, mass, load, phi, phi_q, phi_t, gamma)
    matrix = phi_q(rows, :)
    v = -phi_t(rows)
    call solve(matrix, v)
  end subroutine @NAME@_velocities

  ! The accelerations a that the drivers prescribe: Phi_q a = gamma; with masses also the reactions: Phi_q^T lambda = Q - M a.
  ! Without masses, lambda is zero.
  subroutine @NAME@_accelerations(t, p, u, f, q, v, a, lambda)
    real(real64), intent(in) :: t, p(@P@), u(@U@), f(@F@), q(@N@), v(@N@)
    real(real64), intent(inout) :: a(@N@), lambda(@M@)
    ! The loop equations that determine the motion, in this order.
    integer, parameter :: rows(@N@) = [@ROWS@]
    real(real64) :: mass(@N@, @N@), load(@N@), phi(@M@), phi_q(@M@, @N@), phi_t(@M@), gamma(@M@), matrix(@N@, @N@)
    call @NAME@_equations(t, p, u, f, q, v, mass, load, phi, phi_q, phi_t, gamma)
    matrix = phi_q(rows, :)
    a = gamma(rows)
    call solve(matrix, a)
    lambda = 0.0_real64
@MASSES@
    matrix = transpose(phi_q(rows, :))
    load = load - matmul(mass, a)
    call solve(matrix, load)
    lambda(rows) = load
@END@
  end subroutine @NAME@_accelerations
