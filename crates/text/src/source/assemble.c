/* One Newton step of least length, in units of the scales, onto the loop equations and the conditions of the start. */
static int @_correct_$LEVEL$(@_model *m, double *largest)
{
    double j[$ROWS$][$COLUMNS$], s[$ROWS$][$ROWS$], b[$ROWS$], gap[@_ROWS + 1] = { 0.0 }, condition[2 * $CONDITIONS$ + 1] = { 0.0 }, entry[$ENTRIES$] = { 0.0 };
    int i, k, l;
    for (i = 0; i < $ROWS$; i++) {
        for (k = 0; k < $COLUMNS$; k++) {
            j[i][k] = 0.0;
        }
    }
    @_$GAP$(m, &m->x, gap);
    @_jacobian(m, &m->x, entry);
    for (i = 0; i < $LOOP_ENTRIES$; i++) {
        j[@_$LEVEL$_loop_entries[i][0]][@_$LEVEL$_loop_entries[i][1]] += entry[@_$LEVEL$_loop_entries[i][2]];
    }
    @_$LEVEL$_condition(m, &m->x, condition);
    @_$LEVEL$_condition_jacobian(m, &m->x, entry);
    for (i = 0; i < $CONDITION_ENTRIES$; i++) {
        j[@_$LEVEL$_condition_entries[i][0]][@_$LEVEL$_condition_entries[i][1]] += entry[@_$LEVEL$_condition_entries[i][2]];
    }
    *largest = 0.0;
    for (i = 0; i < $ROWS$; i++) {
        const int row = @_$LEVEL$_row[i];
        b[i] = (row < @_ROWS ? gap[row] : condition[row - @_ROWS] - condition[row - @_ROWS + $CONDITIONS$]) / @_$LEVEL$_row_scale[i];
        if (!(fabs(b[i]) <= *largest)) {
            *largest = fabs(b[i]);
        }
        for (k = 0; k < $COLUMNS$; k++) {
            j[i][k] *= @_$LEVEL$_column_scale[k] / @_$LEVEL$_row_scale[i];
        }
    }
    for (i = 0; i < $ROWS$; i++) {
        double size = 0.0;
        for (l = 0; l <= i; l++) {
            double sum = 0.0;
            for (k = 0; k < $COLUMNS$; k++) {
                sum += j[i][k] * j[l][k];
            }
            size = sum;
            for (k = 0; k < l; k++) {
                sum -= s[i][k] * s[l][k];
            }
            if (l < i) {
                s[i][l] = sum / s[l][l];
            } else if (!(sum > $PIVOT$ * size)) {
                return @_ASSEMBLY;
            } else {
                s[i][i] = sqrt(sum);
            }
        }
        for (k = 0; k < i; k++) {
            b[i] -= s[i][k] * b[k];
        }
        b[i] /= s[i][i];
    }
    for (i = $ROWS$ - 1; i >= 0; i--) {
        for (k = i + 1; k < $ROWS$; k++) {
            b[i] -= s[k][i] * b[k];
        }
        b[i] /= s[i][i];
    }
    for (k = 0; k < $COLUMNS$; k++) {
        double step = 0.0;
        for (i = 0; i < $ROWS$; i++) {
            step -= j[i][k] * b[i];
        }
        if (!(fabs(step) <= $REACH$)) {
            return @_ASSEMBLY;
        }
        *(k < $UNKNOWNS$ ? &m->x.$X$[k] : &m->x.$FX$[k - $UNKNOWNS$]) += step * @_$LEVEL$_column_scale[k];
    }
    return @_OK;
}

