//! Fortran 2008, free form.

use std::fmt::Write;

use super::syntax::Syntax;
use super::{CodeFunction, KinematicsCode, Language, Sizes, Statement};

const HELPERS: &str = "
  pure subroutine sine_cosine(x, sine, cosine)
    real(real64), intent(in) :: x
    real(real64), intent(out) :: sine, cosine
    sine = sin(x)
    cosine = cos(x)
  end subroutine sine_cosine

  elemental real(real64) function signum(x)
    real(real64), intent(in) :: x
    signum = merge(1.0_real64, merge(-1.0_real64, x, x < 0.0_real64), x > 0.0_real64)
  end function signum

  elemental real(real64) function round_down(x)
    real(real64), intent(in) :: x
    round_down = aint(x)
    if (round_down > x) round_down = round_down - 1.0_real64
  end function round_down

  elemental real(real64) function smaller(a, b)
    real(real64), intent(in) :: a, b
    smaller = merge(a, b, a < b .or. a /= a)
  end function smaller

  elemental real(real64) function larger(a, b)
    real(real64), intent(in) :: a, b
    larger = merge(a, b, a > b .or. a /= a)
  end function larger

  ! Solves A x = b by elimination with row exchanges; b becomes x. Not finite if A is singular.
  pure subroutine solve(a, b)
    real(real64), intent(inout) :: a(:, :), b(:)
    real(real64) :: row(size(b)), held
    integer :: k, i, pivot
    do k = 1, size(b)
      pivot = k - 1 + maxloc(abs(a(k:, k)), 1)
      row = a(k, :)
      a(k, :) = a(pivot, :)
      a(pivot, :) = row
      held = b(k)
      b(k) = b(pivot)
      b(pivot) = held
      do i = k + 1, size(b)
        held = a(i, k) / a(k, k)
        a(i, k:) = a(i, k:) - held * a(k, k:)
        b(i) = b(i) - held * b(k)
      end do
    end do
    do i = size(b), 1, -1
      b(i) = (b(i) - dot_product(a(i, i + 1:), b(i + 1:))) / a(i, i)
    end do
  end subroutine solve
";

const SYNTAX: Syntax = Syntax {
    column: 1,
    assign: "    {x} = {v}\n",
    store: "    {x} = {v}\n",
    select: "merge({b}, {c}, {a} /= 0.0_real64)",
    sine_cosine: "    call sine_cosine({a}, {x}, {y})\n",
    call: "{f}({a}{b})",
    special: [
        "ieee_value(t, ieee_quiet_nan)",
        "ieee_value(t, ieee_positive_inf)",
        "(-ieee_value(t, ieee_positive_inf))",
    ],
    suffix: "_real64",
    parentheses: true,
    renamed: &[("M", "mass"), ("Q", "load"), ("Phi", "phi"), ("Phi_q", "phi_q"), ("Phi_t", "phi_t")],
    place: |[row, column], columns| match columns {
        Some(_) => format!("({}, {})", row + 1, column + 1),
        None => format!("({})", row + 1),
    },
};

/// A module with subroutines. Upper and lower case are the same here, so the arrays have longer names.
#[derive(Clone, Copy, Debug)]
pub struct Fortran;

impl Language for Fortran {
    fn prelude(&self, name: &str, legend: &[String]) -> String {
        let mut text = format!("! Equations of motion of `{name}`, Fortran 2008.\n");
        legend.iter().for_each(|line| text += &format!("! {line}\n"));
        let module = identifier(name);
        text + &format!(
            "module {module}_model\n  use, intrinsic :: iso_fortran_env, only: real64\n  \
             use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf\n  \
             implicit none\n  \
             private :: sine_cosine, signum, round_down, smaller, larger, solve\ncontains\n{HELPERS}"
        )
    }

    fn function(&self, function: &CodeFunction, sizes: &Sizes, steps: &[Statement]) -> String {
        let name = identifier(&function.name);
        let outputs: Vec<&str> = function.outputs.iter().map(|output| SYNTAX.array(output.name())).collect();
        let known = if function.knows_motion { "a, lambda, " } else { "" };
        let states = if sizes.states > 0 { "z, " } else { "" };
        let mut text = format!(
            "\n  ! {}\n  subroutine {name}(t, p, u, f, q, v, {states}{known}&\n      {})\n    real(real64), intent(in) :: t\n",
            function.comment().join("\n  ! "),
            outputs.join(", ")
        );
        let Sizes { parameters, inputs, followers, coordinates, constraints, .. } = sizes;
        let mut arguments =
            vec![("p", *parameters), ("u", 3 * inputs), ("f", 3 * followers), ("q", *coordinates), ("v", *coordinates)];
        if sizes.states > 0 {
            arguments.push(("z", sizes.states));
        }
        if function.knows_motion {
            arguments.extend([("a", *coordinates), ("lambda", *constraints)]);
        }
        for (argument, size) in arguments {
            let _ = writeln!(text, "    real(real64), intent(in) :: {argument}({size})"); // writing to a string cannot fail
        }
        for output in function.outputs {
            let [rows, columns] = output.shape(sizes);
            let shape = if output.is_matrix() { format!("{rows}, {columns}") } else { rows.to_string() };
            let _ = writeln!(text, "    real(real64), intent(inout) :: {}({shape})", SYNTAX.array(output.name())); // as above
        }
        for names in locals(steps).chunks(8) {
            let _ = writeln!(text, "    real(real64) :: {}", names.join(", ")); // as above
        }
        text.push_str(&SYNTAX.lines(steps, sizes));
        text + &format!("  end subroutine {name}\n")
    }

    fn kinematics(&self, model: &KinematicsCode) -> String {
        let [equations, velocities, accelerations] =
            ["equations", "velocities", "accelerations"].map(|function| format!("{}_{function}", model.name));
        model
            .fill(include_str!("kinematics.f90"), "@NAME@", 1)
            .replace("@NAME@_equations", &identifier(&equations))
            .replace("@NAME@_velocities", &identifier(&velocities))
            .replace("@NAME@_accelerations", &identifier(&accelerations))
    }

    fn end(&self, name: &str) -> String {
        format!("end module {}_model\n", identifier(name))
    }
}

/// Names begin with a letter and have at most 63 characters.
fn identifier(name: &str) -> String {
    let trimmed = name.trim_start_matches('_');
    let begins_well = trimmed.starts_with(|c: char| c.is_ascii_alphabetic());
    let name = if begins_well { trimmed.to_owned() } else { format!("m{trimmed}") };
    if name.len() <= 56 {
        return name;
    }
    // The end identifies the function.
    let tails = ["_equations", "_velocities", "_accelerations", "_slides", "_efforts"];
    let tail = tails.into_iter().find(|tail| name.ends_with(tail)).unwrap_or("");
    format!("{}{tail}", &name[..40])
}

fn locals(steps: &[Statement]) -> Vec<String> {
    let results = steps.iter().flat_map(|step| match *step {
        Statement::One(number, ..) | Statement::Two(number, ..) | Statement::Select(number, ..) => vec![number],
        Statement::SineCosine(pair, _) => pair.to_vec(),
        Statement::Store(..) => Vec::new(),
    });
    results.map(|index| format!("x{index}")).collect()
}
