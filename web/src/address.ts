/** Where the server is: the page's own host, or what `?ws=` says; `?token=` is handed on. */

export function serverAddress(page: URL): string {
  const given = page.searchParams.get("ws");
  const address = new URL(given ?? `${page.protocol === "https:" ? "wss:" : "ws:"}//${page.host}/`);
  const token = page.searchParams.get("token");
  if (token !== null && !address.searchParams.has("token")) address.searchParams.set("token", token);
  return address.href;
}
