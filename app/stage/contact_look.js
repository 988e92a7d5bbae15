// How arms and λ look in the scene, where viser has no option for it: an arm is seen when all of its links are loaded, hand and all; skins
// and capsules of the contact are drawn as rims, the line of contact through everything, and an arm takes on the tint of λ, which is the x
// of the node /tint/ARM. Without this script they are plain.
(() => {
  // Interval of the check for a new scene [ms].
  const LOOK_MS = 400;
  const TINTED = 0.85;
  // What has a colour of its own keeps it: the orange arm stays orange, and its covers and rings take on the tint. Of 1.
  const COLOURED = 0.5;
  const SHELL = /\/(skin|capsule)_of_[^/]*$/;
  const never = () => {};
  const nodes = () => window.__viserMutable?.nodeRefFromName ?? {};
  const meshes = (node, draw) => {
    node.traverse((object) => {
      if (object.isMesh && object.material) draw(object);
    });
  };

  // Full at the edge and faint where one looks straight at it, so that what is inside is seen.
  const rim = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <opaque_fragment>",
      `float duetRim = 1.0 - abs(dot(normalize(vViewPosition), normal));
       outgoingLight = diffuseColor.rgb;
       diffuseColor.a = min(1.0, opacity * (0.3 + 2.7 * duetRim * duetRim));
       #include <opaque_fragment>`,
    );
  };
  const drawShell = (mesh) => {
    // It hangs on a link that can be clicked, but is not a part of it.
    mesh.raycast = never;
    const material = mesh.material;
    if (material.onBeforeCompile === rim || !material.isMeshStandardMaterial) return;
    material.onBeforeCompile = rim;
    material.customProgramCacheKey = () => "duet-rim";
    material.depthWrite = false;
    material.toneMapped = false;
    material.needsUpdate = true;
  };
  const drawThrough = (mesh) => {
    mesh.renderOrder = mesh.material.isLineMaterial ? 1000 : 1001;
    mesh.material.depthTest = false;
    if (mesh.material.transparent) return;
    mesh.material.transparent = true;
    mesh.material.needsUpdate = true;
  };
  const coloured = ({ r, g, b }) => Math.max(r, g, b) - Math.min(r, g, b) > COLOURED * Math.max(r, g, b);
  // The arms of the fast picture are painted vertex by vertex, and white apart from that.
  const tintGrey = function (shader) {
    shader.uniforms.duetTint = { value: this.userData.duetTint };
    shader.fragmentShader = `uniform vec3 duetTint;\n${shader.fragmentShader}`.replace(
      "#include <color_fragment>",
      `#include <color_fragment>
       float duetHigh = max(vColor.r, max(vColor.g, vColor.b)), duetLow = min(vColor.r, min(vColor.g, vColor.b));
       if (duetHigh - duetLow <= ${COLOURED.toFixed(2)} * duetHigh) diffuseColor.rgb *= duetTint;`,
    );
  };
  const drawTint = (mesh, share) => {
    const material = mesh.material;
    // What is translucent hangs on the arm, but is not its own.
    if (material.transparent || !material.color || material.userData.duetShare === share) return;
    material.userData.duetShare = share;
    material.userData.duetColor ??= material.color.clone();
    if (coloured(material.userData.duetColor)) return;
    if (material.vertexColors && !material.userData.duetTint) {
      material.userData.duetTint = material.color.clone();
      material.onBeforeCompile = tintGrey;
      material.customProgramCacheKey = () => "duet-tint";
      material.needsUpdate = true;
    }
    // Mixed as one sees it, not as light adds up: half of the tint is to look like half.
    const tint = material.color.clone().set(duet.tint).convertLinearToSRGB();
    (material.userData.duetTint ?? material.color)
      .copy(material.userData.duetColor)
      .convertLinearToSRGB()
      .lerp(tint, TINTED * share)
      .convertSRGBToLinear();
  };

  // All links of an arm load at the same time, and come one by one: it is seen with the last of them. The node at its end names them all.
  const BASE = /^\/(?:arms|ghost|wish)\/[^/]+\/base$/;
  const isWhole = (base) => {
    const end = Object.keys(nodes()).find((name) => name.startsWith(`${base}/`) && name.endsWith("/whole"));
    const up = (name) => name.slice(0, name.lastIndexOf("/"));
    let link = end ? up(end) : "";
    while (link.length > base.length && nodes()[`${link}/shape`]) link = up(link);
    return link === base && Boolean(nodes()[`${link}/shape`]);
  };
  const awaited = new Set();

  // A drawn frame looks at these; they are made again when a node has come or gone.
  let known = [];
  let parts = [];
  let lines = [];
  let shells = [];
  let arms = [];
  const find = () => {
    const now = Object.values(nodes());
    if (now.length === known.length && now.every((node, place) => node === known[place])) return;
    known = now;
    parts = lines = shells = arms = [];
    for (const [name, node] of Object.entries(nodes())) {
      if (!node) continue;
      if (BASE.test(name)) {
        if (!isWhole(name)) parts = [...parts, node];
        else if (awaited.delete(node)) node.visible = true;
      } else if (name.startsWith("/closest/")) lines = [...lines, node];
      else if (name.startsWith("/tint/")) {
        const own = [];
        const arm = nodes()[`/arms/${name.slice(6)}/base`];
        if (arm) meshes(arm, (mesh) => own.push(mesh));
        arms = [...arms, [node, own]];
      } else if (SHELL.test(name)) shells = [...shells, node];
    }
  };

  const draw = () => {
    find();
    for (const node of parts) {
      awaited.add(node);
      node.visible = false;
    }
    for (const node of lines) meshes(node, drawThrough);
    for (const node of shells) meshes(node, drawShell);
    for (const [node, own] of arms) for (const mesh of own) drawTint(mesh, node.position.x);
  };
  const attached = () => {
    let scene = nodes()[""];
    while (scene?.parent) scene = scene.parent;
    if (!scene?.isScene) return false;
    if (scene.onBeforeRender !== draw) {
      scene.onBeforeRender = draw;
      window.__viserMutable.requestRender();
    }
    return true;
  };
  // In the first frame of the scene, before an arm can be loaded.
  const attach = () => attached() || requestAnimationFrame(attach);
  attach();
  setInterval(attached, LOOK_MS);
})();
