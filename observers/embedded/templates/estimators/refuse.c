    if (!(is_known(output[OUT_MU]) && is_known(output[OUT_MU_STD]) && is_known(output[OUT_M_Z_PREDICTED]))) {
        /* The patch has moved: what it has become is not to be relied on. */
        ${name}_reset(state);
        state->output[OUT_STATUS] = ${NAME}_REFUSED;
        return ${NAME}_REFUSED;
    }
