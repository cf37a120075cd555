    range->below_count = 0;
