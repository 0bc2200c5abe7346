/* The start for other values than those of the export: the configuration that is reached from the one found there, and the least rates. */
static int @_assemble(@_model *m)
{
    double r[@_ROWS + 1];
    int i;
//?searched
    double largest = 0.0;
    int status;
//.
//?guessed
    double condition[$CONDITION_RESULTS$];
    @_position_condition(m, &m->x, condition);
    for (i = 0; i < $GUESSES$; i++) {
        if (!(fabs(condition[@_guess[i]] - @_guessed[i]) <= $SAME$ * (1.0 + fabs(@_guessed[i])))) {
            return @_ASSEMBLY;
        }
    }
//.
//?positions
    for (i = 0; i < 20; i++) {
        status = @_correct_position(m, &largest);
        if (status != @_OK) {
            return status;
        }
//?undetermined
        if (!(largest <= $CLOSE$)) {
            return @_ASSEMBLY;
        }
//.
    }
    if (!(largest <= $CLOSE$)) {
        return @_ASSEMBLY;
    }
//.
    for (i = 0; i < @_RATES; i++) {
        m->x.v[i] = 0.0;
    }
    for (i = 0; i < @_FOLLOWERS; i++) {
        m->x.f_rate[i] = 0.0;
    }
//?velocities
    for (i = 0; i < 2; i++) {
        status = @_correct_velocity(m, &largest);
        if (status != @_OK) {
            return status;
        }
    }
    if (!(largest <= $CLOSE$)) {
        return @_ASSEMBLY;
    }
//.
    @_constraint(m, &m->x, r);
    for (i = 0; i < @_ROWS; i++) {
        if (!(fabs(r[i]) <= $CLOSE$ * @_gap_scale[i])) {
            return @_ASSEMBLY;
        }
    }
    return @_OK;
}
