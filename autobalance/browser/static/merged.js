// Tables of a job in three states: as they were, as they are here since, as they came from elsewhere.
const isTable = (value) => typeof value === "object" && value !== null && !Array.isArray(value);
const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

// What came, with what was changed here since: of a key that both changed, the one here counts.
export function merged(before, here, come) {
  const made = { ...come };
  for (const key of new Set([...Object.keys(before), ...Object.keys(here)])) {
    if (same(before[key], here[key])) continue;
    const isInside = [before[key] ?? {}, here[key], come[key] ?? {}].every(isTable);
    if (isInside) made[key] = merged(before[key] ?? {}, here[key], come[key] ?? {});
    else if (here[key] === undefined) delete made[key];
    else made[key] = here[key];
  }
  return made;
}
