//! Free-living cohorts made from people, behaviour, body, sensor and pump
