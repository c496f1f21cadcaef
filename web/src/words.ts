/** Names in a list before the rest is counted. */
const MOST_NAMES = 3;

/** A list as people say it: a, b and c; a, b and 3 more. */
export function listed(names: string[]): string {
  const rest = names.length - MOST_NAMES, said = rest > 1 ? [...names.slice(0, MOST_NAMES), `${rest} more`] : names;
  return said.length < 2 ? said.join("") : `${said.slice(0, -1).join(", ")} and ${said[said.length - 1]}`;
}
